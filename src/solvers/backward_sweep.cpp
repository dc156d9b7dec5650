#include "solvers/backward_sweep.hpp"

#include <algorithm>

#include "solvers/finite_check.hpp"
#include "solvers/lane_copy.hpp"
#include "solvers/lane_gemm.hpp"

namespace conddp {
namespace {

int largest_nu(const ShootingProblem& problem) {
  int largest = 0;
  for (int k = 0; k < problem.knots(); ++k) largest = std::max(largest, problem.nu(k));
  return largest;
}

}  // namespace

BackwardSweep::BackwardSweep(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds),
      values_(problem.knots() + 1, ValueFunction(problem.ndx())),
      next_(problem.ndx()),
      propagation_(problem.ndx(), largest_nu(problem)),
      q_(problem.ndx(), largest_nu(problem)),
      columns_(problem.ndx() + largest_nu(problem), largest_nu(problem)),
      Kt_(problem.ndx() + 1, largest_nu(problem)),
      M_(problem.ndx(), largest_nu(problem)),
      w_(largest_nu(problem)) {
  for (int k = 0; k < problem.knots(); ++k) Quu_.emplace_back(problem.nu(k), problem.nu(k));
}

int BackwardSweep::run(const Linearization& linearization, const Trajectory& trajectory,
                       const Gaps& gaps, SweepRegularization regularization, StagePolicy& policy,
                       Feedback& feedback, bool hold, std::optional<int> from) {
  const int N = bounds_.knots();
  policy.begin_horizon(linearization, gaps);
  policy.begin_sweep(hold);
  if (!from) {
    values_[N].Vx = linearization.knots[N].gradient;
    values_[N].Vxx = linearization.knots[N].hessian;
  }
  for (int k = from.value_or(N - 1); k >= 0; --k) {
    const KnotLinearization& knot = linearization.knots[k];
    const bool open = !gaps[k].closed();
    if (open) {
      next_ = values_[k + 1];
      gaps[k].pull(next_);
    }
    propagation_.propagate(knot, open ? next_ : values_[k + 1], q_);
    Quu_[k] = q_.Quu();
    if (!solve_stage(k, trajectory, knot, regularization, policy, feedback)) return k;
    const bool true_gains = regularization.weight == 0 && policy.minimizes_freely();
    if (!form_value(values_[k], feedback.k[k], true_gains)) return k;
  }
  return -1;
}

bool BackwardSweep::solve_stage(int k, const Trajectory& trajectory, const KnotLinearization& knot,
                                SweepRegularization regularization, StagePolicy& policy,
                                Feedback& feedback) {
  const int nu = q_.nu(), ndx = q_.ndx();
  if (nu == 0) {
    policy.pass(k);
    return true;
  }
  const bool regular = regularization.weight > 0;
  columns_.resize(q_.nz(), nu);
  auto columns = regular ? columns_.view() : q_.Qzz_lanes().block(q_.nz(), ndx, nu).view();
  if (regular) {
    columns = q_.Qzz().rightCols(nu);
    if (regularization.kind == RegularizationKind::state) {
      propagation_.regularize_state(knot, regularization.weight, columns);
    } else {
      columns.bottomRows(nu).diagonal().array() += regularization.weight;
    }
  }
  Kt_.resize(ndx + 1, nu);
  const StageProblem stage{k,
                           columns.topRows(ndx),
                           columns.bottomRows(nu),
                           q_.Qz().tail(nu),
                           trajectory.u(k),
                           bounds_.lower(k),
                           bounds_.upper(k)};
  if (!policy.solve(stage, feedback.k[k], Kt_.block())) return false;
  transpose(Kt_.data(), Kt_.stride(), ndx, nu, feedback.K[k].data(), nu);
  return true;
}

bool BackwardSweep::form_value(ValueFunction& value, const Eigen::VectorXd& k, bool true_gains) {
  const int nu = q_.nu(), ndx = q_.ndx();
  LaneMatrix& Q = q_.Qzz_lanes();
  // V_xx in the lower triangle, where Q_xx is, and V_x where Q_x is.
  const LaneBlock Vxx = Q.block(ndx, 0, ndx), Vx{q_.Qz().data(), Q.stride(), ndx, 1};
  if (nu > 0) {
    const LaneBlock Kt = Kt_.block(ndx, 0, nu), Qxu = Q.block(ndx, ndx, nu);
    if (!true_gains) {
      // (Kᵀ Q_uu + Q_xu) K vanishes only where K minimises with the true Q_uu.
      M_.resize(ndx, nu);
      M_.view() = q_.Qxu();
      multiply(Store::add, M_.block(), Kt, {Q.col(ndx) + ndx, 1, Q.stride()});
      multiply_lower(Store::add, Vxx, M_.block(), Factor::transposed(Kt_));
    }
    multiply_lower(Store::add, Vxx, Kt, {Q.col(ndx), Q.stride(), 1});
    auto w = w_.head(nu);
    w = q_.Qu();
    w.noalias() += q_.Quu() * k;
    // The last whole lane reaches into Q_u, which is not needed any more.
    multiply(Store::add, Vx, Kt, {w.data(), 1, nu});
    multiply(Store::add, Vx, Qxu, {k.data(), 1, nu});
  }
  value.Vx = q_.Qx();
  return copy_symmetric(Vxx, value.Vxx.data(), ndx) && all_finite(value.Vx);
}

}  // namespace conddp
