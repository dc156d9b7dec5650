#pragma once

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

int largest_nu(const ShootingProblem& problem);

/// The problem in δu that a sweep solves at a knot: minimize ½ δuᵀ Q_uu δu + (Q_u + Q_ux δx)ᵀ δu,
/// where Q_uu and Q_ux may be regularized.
struct StageProblem {
  using Vector = Eigen::Map<const Eigen::VectorXd>;

  int knot;
  ConstStridedView Qxu;  ///< ndx x nu
  ConstStridedView Quu;  ///< nu x nu
  Vector Qu;             ///< nu
  Vector u;              ///< the knot's current control
  Vector lower, upper;   ///< of the control, infinite if free

  /// Writes the right-hand side of control i: column j of `to` (one row more than Q_xu) ← −(Q_xu;
  /// Q_uᵀ).
  void negate(int i, const LaneBlock& to, int j) const;
  /// Minimizes without bounds, k = −Q_uu⁻¹ Q_u and K = −Q_uu⁻¹ Q_ux, by a Cholesky factorization in
  /// `factor`. Outputs and result as in `StageSolver::solve`.
  bool solve_free(LaneMatrix& factor, Eigen::Ref<Eigen::VectorXd> k, const LaneBlock& Kt) const;
};

}  // namespace conddp
