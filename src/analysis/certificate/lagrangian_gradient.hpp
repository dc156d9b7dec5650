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

/// Co-states λ and the gradient of the Lagrangian with respect to the controls, by an adjoint pass
/// along a policy δu = K δx. With ℓ̄ = s ℓ + νᵀg and the closed step f̄ = f ⊕ (−gap) ⊖ x_{k+1},
///   λ_N = ∇ℓ̄_N,  ∇_u L = ℓ̄_u + f̄_uᵀ λ_{k+1},  λ_k = ℓ̄_x + f̄_xᵀ λ_{k+1} + Kᵀ ∇_u L.
/// With K = 0, ∇_u L is the reduced gradient: that of cost and νᵀg with respect to the controls,
/// with states that follow from them. K has zero rows for controls at a bound. In the other
/// controls, ∇_u L therefore vanishes at the same trajectories for all K.
struct AdjointPass {
  Eigen::MatrixXd costates;              ///< ndx x (N + 1)
  std::vector<Eigen::VectorXd> control;  ///< ∇_u L, nu per knot
  /// Effect of rounding on ∇_u L: the largest change of an entry if every intermediate term changes
  /// by kAdjointRounding of itself, with a random sign.
  double rounding = 0;
};

/// Relative rounding of terms from contact derivatives, as badly conditioned as they may be.
inline constexpr double kAdjointRounding = 1e-13;

/// `multipliers`: ν, one number per constraint row. `gains`: K, nu x ndx per knot; empty for K = 0.
AdjointPass adjoint_pass(const ShootingProblem& problem,
                         const std::vector<NodeDerivatives>& derivatives,
                         const Eigen::VectorXd& multipliers,
                         const std::vector<Eigen::MatrixXd>& gains);

/// A control within this distance of a bound, relative to max(1, |bound|), is at it: rounding.
inline constexpr double kBoundRounding = 1e-14;

/// Policy of a plain Riccati recursion; it depends only on problem and trajectory.
struct RiccatiPolicy {
  /// Allocates the policy for the knots of a problem, without values.
  explicit RiccatiPolicy(const ShootingProblem& problem);

  std::vector<Eigen::MatrixXd> K;  ///< nu x ndx per knot
  /// Q_uu⁻¹ of the controls that K moves, zero in the rows and columns of the others. In the v of
  /// δu = v + K δx, the model's Hessian consists of the blocks Q_uu.
  std::vector<Eigen::MatrixXd> inverse;
  /// True if all stages have a minimum; controls of the others are left unchanged.
  bool convex = true;

  /// Model decrease by the step for this gradient along K, ½ Σ ∇_uᵀ Q_uu⁻¹ ∇_u; NaN if the model is
  /// not convex.
  double decrease(const std::vector<Eigen::VectorXd>& gradient) const;
};

/// Uses the Gauss-Newton `hessians`. δu = K δx minimizes the cost model over the controls at no
/// bound, along the linearized dynamics; the rows of the others are zero.
RiccatiPolicy riccati_policy(const ShootingProblem& problem, const Trajectory& trajectory,
                             const std::vector<NodeDerivatives>& derivatives,
                             const std::vector<Eigen::MatrixXd>& hessians,
                             double bound_tolerance = kBoundRounding);

/// Gradient with respect to the controls, with multipliers of their bounds. An entry counts for
/// `product` if its control is at a bound that descent would cross, otherwise for `stationarity`.
struct ProjectedGradient {
  double stationarity = 0;    ///< largest entry
  double product = 0;         ///< largest entry times the distance from its bound
  int knot = -1, entry = -1;  ///< place of `stationarity`, or −1
};
ProjectedGradient project(const ShootingProblem& problem, const Trajectory& trajectory,
                          const std::vector<Eigen::VectorXd>& gradient,
                          double bound_tolerance = kBoundRounding);

}  // namespace conddp
