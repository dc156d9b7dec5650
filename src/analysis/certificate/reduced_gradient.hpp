#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/node_derivatives.hpp"

namespace conddp {

/// Co-states λ and the gradient of the Lagrangian in the controls, by an adjoint pass along a
/// policy δu = K δx: with ℓ̄ = s ℓ + νᵀg and the closed step f̄ = f ⊕ (−gap) ⊖ x_{k+1},
///   λ_N = ∇ℓ̄_N,  ∇_u L = ℓ̄_u + f̄_uᵀ λ_{k+1},  λ_k = ℓ̄_x + f̄_xᵀ λ_{k+1} + Kᵀ ∇_u L.
/// With K = 0 ∇_u L is the reduced gradient: that of cost and νᵀg by the controls, where states
/// follow from them. K has no rows for controls that stand at a bound: so ∇_u L vanishes in the
/// others at the same trajectories for every K.
struct AdjointPass {
  Eigen::MatrixXd costates;              ///< ndx x (N + 1)
  std::vector<Eigen::VectorXd> control;  ///< ∇_u L, nu, one a knot
  /// What rounding does to ∇_u L: the largest change of an entry where every term on the way to it
  /// moves by kAdjointRounding of itself, up or down by chance.
  double rounding = 0;
};

/// Of terms that come from derivatives of contacts, as badly conditioned as they may be.
inline constexpr double kAdjointRounding = 1e-13;

/// `multipliers`: ν, one number a constraint row. `gains`: K, nu x ndx, one a knot; none: 0.
AdjointPass adjoint_pass(const ShootingProblem& problem,
                         const std::vector<NodeDerivatives>& derivatives,
                         const Eigen::VectorXd& multipliers,
                         const std::vector<Eigen::MatrixXd>& gains);

/// How near to a bound, relative to it or 1, a control stands at it: rounding.
inline constexpr double kBoundRounding = 1e-14;

/// A plain Riccati recursion: what it gives depends on problem and trajectory alone.
struct RiccatiPolicy {
  /// That of a problem's knots, with numbers that are not set.
  explicit RiccatiPolicy(const ShootingProblem& problem);

  std::vector<Eigen::MatrixXd> K;  ///< nu x ndx, one a knot
  /// Q_uu⁻¹ of the controls that K moves, zero in the rows and columns of the others: in v of
  /// δu = v + K δx the model's Hessian consists of the blocks Q_uu.
  std::vector<Eigen::MatrixXd> inverse;
  std::vector<Eigen::MatrixXd> Q;      ///< nz x nz, of the stage of each knot
  std::vector<Eigen::MatrixXd> value;  ///< ndx x ndx, one a node: Hessian of the cost to go
  /// Whether all stages have a minimum; the controls of others are left alone.
  bool convex = true;

  /// What the model gains by the step that this gradient along K asks for, ½ Σ ∇_uᵀ Q_uu⁻¹ ∇_u;
  /// not-a-number where it has no minimum.
  double decrease(const std::vector<Eigen::VectorXd>& gradient) const;
};

/// With the Gauss-Newton `hessians`: δu = K δx minimises the model of the costs over the controls
/// that stand at no bound, along the linear dynamics; the rows of the others are zero.
RiccatiPolicy riccati_policy(const ShootingProblem& problem, const Trajectory& trajectory,
                             const std::vector<NodeDerivatives>& derivatives,
                             const std::vector<Eigen::MatrixXd>& hessians,
                             double bound_tolerance = kBoundRounding);

/// A gradient in the controls, with multipliers of their bounds: where a control stands at one that
/// descent would cross, it counts for `product`, else for `stationarity`.
struct ProjectedGradient {
  double stationarity = 0;    ///< largest entry
  double product = 0;         ///< largest entry times the distance from its bound
  int knot = -1, entry = -1;  ///< where `stationarity` is attained, −1: nowhere
};
ProjectedGradient project(const ShootingProblem& problem, const Trajectory& trajectory,
                          const std::vector<Eigen::VectorXd>& gradient,
                          double bound_tolerance = kBoundRounding);

}  // namespace conddp
