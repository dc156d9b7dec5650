#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/problem.hpp"

namespace conddp {

/// The gradient of the Lagrangian by every state and control, at given co-states λ and multipliers
/// ν of the constraints:
///   ∇_{x_k} = ∂/∂x [s ℓ_k + λ_{k+1}ᵀ (f_k ⊕ (−gap_k) ⊖ x_{k+1}) + ν_kᵀ g_k] − λ_k,
///   ∇_{u_k} = ∂/∂u [s ℓ_k + λ_{k+1}ᵀ (f_k ⊕ (−gap_k) ⊖ x_{k+1}) + ν_kᵀ g_k],
/// for dynamics that keep the gaps they have. Bounds on controls have no terms in it.
struct LagrangianGradient {
  Eigen::MatrixXd state;                      ///< one row a direction, N + 1 columns
  std::vector<Eigen::VectorXd> control;       ///< nu, one a knot
  Eigen::MatrixXd state_size;                 ///< sums of the absolute values of each entry's terms
  std::vector<Eigen::VectorXd> control_size;  ///< likewise: rounding is relative to them
};

/// Evaluates it by dual numbers through the evaluation of costs, constraints and dynamics: no
/// formula of a derivative that solvers use has a part in it. `gap` is ndx x N, `costates`
/// ndx x (N + 1), `multipliers` one number a constraint row of the problem. Of the states'
/// gradients come the products with the columns of `directions` (ndx rows): the identity gives all
/// entries, and a few random columns tell at less cost whether they are what somebody says.
LagrangianGradient lagrangian_gradient(const ShootingProblem& problem, const Trajectory& trajectory,
                                       const Eigen::MatrixXd& gap, const Eigen::MatrixXd& costates,
                                       const Eigen::VectorXd& multipliers,
                                       const Eigen::MatrixXd& directions);

}  // namespace conddp
