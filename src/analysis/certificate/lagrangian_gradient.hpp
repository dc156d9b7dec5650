#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// Gradient of the Lagrangian with respect to every state and control, at given co-states λ and
/// constraint multipliers ν:
///   ∇_{x_k} = ∂/∂x [s ℓ_k + λ_{k+1}ᵀ (f_k ⊕ (−gap_k) ⊖ x_{k+1}) + ν_kᵀ g_k] − λ_k,
///   ∇_{u_k} = ∂/∂u [s ℓ_k + λ_{k+1}ᵀ (f_k ⊕ (−gap_k) ⊖ x_{k+1}) + ν_kᵀ g_k],
/// for dynamics that preserve the current gaps. Control bounds contribute no terms.
struct LagrangianGradient {
  Eigen::MatrixXd state;                      ///< ndx x (N + 1)
  std::vector<Eigen::VectorXd> control;       ///< nu per knot
  Eigen::MatrixXd state_size;                 ///< sum of the absolute values of each entry's terms
  std::vector<Eigen::VectorXd> control_size;  ///< likewise; rounding is relative to these sizes
};

/// Uses the derivatives at a trajectory. `costates` are ndx x (N + 1), `multipliers` one number per
/// constraint row of the problem.
LagrangianGradient lagrangian_gradient(const ShootingProblem& problem,
                                       const std::vector<NodeDerivatives>& derivatives,
                                       const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers);

/// Gradient of one node's terms of the Lagrangian with respect to its z: ∂/∂z [s ℓ_k + λᵀ (f_k ⊕ …)
/// + ν_kᵀ g_k]. `size` is the sum of the absolute values of each entry's terms.
struct NodeGradient {
  Eigen::VectorXd value, size;
};

/// `multipliers` are those of all constraints. `next` is λ of the next node (ndx numbers), or null
/// at the terminal node.
void node_gradient(const ShootingProblem& problem, const NodeDerivatives& derivatives, int node,
                   const Eigen::VectorXd& multipliers, const double* next, NodeGradient& out);

}  // namespace conddp
