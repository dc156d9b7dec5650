#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// The gradient of the Lagrangian by every state and control, at given co-states λ and multipliers
/// ν of the constraints:
///   ∇_{x_k} = ∂/∂x [s ℓ_k + λ_{k+1}ᵀ (f_k ⊕ (−gap_k) ⊖ x_{k+1}) + ν_kᵀ g_k] − λ_k,
///   ∇_{u_k} = ∂/∂u [s ℓ_k + λ_{k+1}ᵀ (f_k ⊕ (−gap_k) ⊖ x_{k+1}) + ν_kᵀ g_k],
/// for dynamics that keep the gaps they have. Bounds on controls have no terms in it.
struct LagrangianGradient {
  Eigen::MatrixXd state;                      ///< ndx x (N + 1)
  std::vector<Eigen::VectorXd> control;       ///< nu, one a knot
  Eigen::MatrixXd state_size;                 ///< sums of the absolute values of each entry's terms
  std::vector<Eigen::VectorXd> control_size;  ///< likewise: rounding is relative to them
};

/// Of derivatives at a trajectory. `costates` are ndx x (N + 1), `multipliers` one number a
/// constraint row of the problem.
LagrangianGradient lagrangian_gradient(const ShootingProblem& problem,
                                       const std::vector<NodeDerivatives>& derivatives,
                                       const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers);

/// What one node's terms of the Lagrangian are by its z: ∂/∂z [s ℓ_k + λᵀ (f_k ⊕ …) + ν_kᵀ g_k],
/// and the sum of the absolute values of each entry's terms.
struct NodeGradient {
  Eigen::VectorXd value, size;
};

/// `multipliers` are those of all constraints, `next` is λ of the next node, ndx numbers: null at
/// the terminal one.
void node_gradient(const ShootingProblem& problem, const NodeDerivatives& derivatives, int node,
                   const Eigen::VectorXd& multipliers, const double* next, NodeGradient& out);

}  // namespace conddp
