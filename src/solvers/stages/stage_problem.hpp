#pragma once

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"
#include "solvers/linalg/lane_matrix.hpp"

namespace conddp {

int largest_nu(const ShootingProblem& problem);

/// The problem in δu that the sweep meets at a knot: minimise
/// ½ δuᵀ Q_uu δu + (Q_u + Q_ux δx)ᵀ δu, where Q_uu and Q_ux may be regularised.
struct StageProblem {
  using Vector = Eigen::Map<const Eigen::VectorXd>;

  int knot;
  /// ndx x nu. Sweeps by segments have more rows: linear terms of parameters beside the state.
  ConstStridedView Qxu;
  ConstStridedView Quu;  ///< nu x nu
  Vector Qu;             ///< nu
  Vector u;              ///< the knot's present control
  Vector lower, upper;   ///< of the control, infinite where free
  int segment = 0;       ///< stages of different segments may be solved at once

  /// The right-hand side of a control i: column j of `to` (a row more than Q_xu) ← −(Q_xu; Q_uᵀ).
  void negate(int i, const LaneBlock& to, int j) const;
  /// The minimum without bounds, k = −Q_uu⁻¹ Q_u and K = −Q_uu⁻¹ Q_ux, by Cholesky's factorisation,
  /// for which `factor` has room; as in `StageSolver::solve`.
  bool solve_free(LaneMatrix& factor, Eigen::Ref<Eigen::VectorXd> k, const LaneBlock& Kt) const;
};

}  // namespace conddp
