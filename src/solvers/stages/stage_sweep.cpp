#include "solvers/stages/stage_sweep.hpp"

#include <algorithm>

#include "solvers/common/finite_check.hpp"
#include "solvers/linalg/lane_copy.hpp"
#include "solvers/linalg/lane_gemm.hpp"
#include "solvers/stages/narrow_stage.hpp"

namespace conddp {
namespace {

/// View of some rows of a matrix.
template <class Matrix>
ConstStridedView rows_of(const Matrix& M, int first, int count) {
  return {M.data() + first, count, M.cols(), Eigen::OuterStride<>(M.outerStride())};
}

template <class Vector>
StageProblem::Vector view(const Vector& v) {
  return {v.data(), v.size()};
}

}  // namespace

StageSweep::StageSweep(const ShootingProblem& problem)
    : propagation_(problem.ndx(), largest_nu(problem)),
      q_(problem.ndx(), largest_nu(problem)),
      Kt_(problem.ndx() + 1, largest_nu(problem)),
      M_(problem.ndx(), largest_nu(problem)),
      w_(largest_nu(problem)) {}

void StageSweep::propagate(const SweptHorizon& horizon, int k, const ValueFunction& next) {
  propagation_.propagate(horizon.linearization.knots[k], next, q_, &horizon.gaps[k]);
}

bool StageSweep::solve(const SweptHorizon& horizon, int k, double regularization,
                       StageSolver& stages, Feedback& feedback) {
  const int nu = q_.nu(), ndx = q_.ndx();
  if (regularization > 0) q_.add_to_diagonal(regularization);
  if (nu == 0) {
    stages.pass(k);
    return true;
  }
  const auto columns = q_.Qzz_lanes().block(q_.nz(), ndx, nu).view();
  const StageProblem stage{.knot = k,
                           .Qxu = rows_of(columns, 0, ndx),
                           .Quu = rows_of(columns, ndx, nu),
                           .Qu = view(q_.Qu()),
                           .u = horizon.trajectory.u(k),
                           .lower = view(horizon.bounds.lower(k)),
                           .upper = view(horizon.bounds.upper(k))};
  Kt_.resize(ndx + 1, nu);
  if (!stages.solve(stage, feedback.k[k], Kt_.block())) return false;
  transpose(Kt_.data(), Kt_.stride(), ndx, nu, feedback.K[k].data(), nu);
  return true;
}

bool StageSweep::form_value(ValueFunction& value, const Eigen::VectorXd& k, bool minimizes) {
  const int nu = q_.nu(), ndx = q_.ndx();
  LaneMatrix& Q = q_.Qzz_lanes();
  auto w = w_.head(nu);
  if (nu > 0) {
    w = q_.Qu();
    w.noalias() += q_.Quu() * k;
  }
  if (const NarrowStage* narrow = narrow_stage(ndx, nu); narrow != nullptr && minimizes)
    return narrow->form_value(q_, Kt_.block(), w.data(), k.data(), value);
  // V_xx replaces Q_xx in the lower triangle, and V_x replaces Q_x.
  const LaneBlock Vxx = Q.block(ndx, 0, ndx), Vx{q_.Qz().data(), Q.stride(), ndx, 1};
  if (nu > 0) {
    const LaneBlock Kt = Kt_.block(ndx, 0, nu), Qxu = Q.block(ndx, ndx, nu);
    if (!minimizes) {
      // (Kᵀ Q_uu + Q_xu) K vanishes only if K minimizes.
      M_.resize(ndx, nu);
      M_.view() = q_.Qxu();
      multiply(Store::add, M_.block(), Kt, {Q.col(ndx) + ndx, 1, Q.stride()});
      multiply_lower(Store::add, Vxx, M_.block(), Factor::transposed(Kt_));
    }
    multiply_lower(Store::add, Vxx, Kt, {Q.col(ndx), Q.stride(), 1});
    // The last whole lane reaches into Q_u, which is no longer needed.
    multiply(Store::add, Vx, Kt, {w.data(), 1, nu});
    multiply(Store::add, Vx, Qxu, {k.data(), 1, nu});
  }
  value.Vx = q_.Qx();
  return copy_symmetric(Vxx, value.Vxx.data(), ndx) && all_finite(value.Vx);
}

}  // namespace conddp
