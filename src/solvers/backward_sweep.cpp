#include "solvers/backward_sweep.hpp"

#include <algorithm>

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
      gap_(problem.manifold()),
      propagation_(problem.ndx(), largest_nu(problem)),
      q_(problem.ndx(), largest_nu(problem)),
      columns_((problem.ndx() + largest_nu(problem)) * largest_nu(problem)),
      Kt_(problem.ndx(), largest_nu(problem)),
      M_(problem.ndx(), largest_nu(problem)),
      S_(problem.ndx(), problem.ndx()),
      w_(largest_nu(problem)) {}

int BackwardSweep::run(const Linearization& linearization, const Trajectory& trajectory,
                       bool open_gaps, SweepRegularization regularization, StagePolicy& policy,
                       Feedback& feedback, bool hold) {
  const int N = bounds_.knots();
  policy.begin_sweep(hold);
  values_[N].Vx = linearization.knots[N].gradient;
  values_[N].Vxx = linearization.knots[N].hessian;
  for (int k = N - 1; k >= 0; --k) {
    const KnotLinearization& knot = linearization.knots[k];
    if (open_gaps) {
      next_ = values_[k + 1];
      gap_.set(linearization.gap.col(k));
      gap_.pull(next_);
    }
    propagation_.propagate(knot, open_gaps ? next_ : values_[k + 1], q_);
    if (!solve_stage(k, trajectory, knot, regularization, policy, feedback)) return k;
    form_value(values_[k], feedback.k[k]);
    if (!values_[k].Vx.allFinite() || !values_[k].Vxx.allFinite()) return k;
  }
  return -1;
}

bool BackwardSweep::solve_stage(int k, const Trajectory& trajectory, const KnotLinearization& knot,
                                SweepRegularization regularization, StagePolicy& policy,
                                Feedback& feedback) {
  const int nu = q_.nu(), ndx = q_.ndx();
  if (nu == 0) return true;
  Eigen::Map<Eigen::MatrixXd> columns(columns_.data(), q_.nz(), nu);
  columns = q_.Qzz().rightCols(nu);
  if (regularization.weight > 0) {
    if (regularization.kind == RegularizationKind::state) {
      propagation_.regularize_state(knot, regularization.weight, columns);
    } else {
      columns.bottomRows(nu).diagonal().array() += regularization.weight;
    }
  }
  auto Kt = Kt_.leftCols(nu);
  const StageProblem stage{k,
                           columns.topRows(ndx),
                           columns.bottomRows(nu),
                           q_.Qz().tail(nu),
                           trajectory.u(k),
                           bounds_.lower(k),
                           bounds_.upper(k)};
  if (!policy.solve(stage, feedback.k[k], Kt)) return false;
  feedback.K[k] = Kt.transpose();
  return true;
}

/// With M = Q_xu + ½ Kᵀ Q_uu the products of V_xx collapse to S + Sᵀ, S = M K: symmetric to the
/// last bit.
void BackwardSweep::form_value(ValueFunction& value, const Eigen::VectorXd& k) {
  const int nu = q_.nu();
  value.Vx = q_.Qx();
  value.Vxx = q_.Qxx();
  if (nu == 0) return;
  const auto Kt = Kt_.leftCols(nu);
  auto M = M_.leftCols(nu);
  auto w = w_.head(nu);
  M = q_.Qxu();
  M.noalias() += 0.5 * Kt * q_.Quu();
  S_.noalias() = M * Kt.transpose();
  const int ndx = q_.ndx();
  for (int j = 0; j < ndx; ++j) {
    for (int i = 0; i <= j; ++i) {
      value.Vxx(i, j) += S_(i, j) + S_(j, i);
      value.Vxx(j, i) = value.Vxx(i, j);
    }
  }
  w = q_.Qu();
  w.noalias() += q_.Quu() * k;
  value.Vx.noalias() += Kt * w;
  value.Vx.noalias() += q_.Qxu() * k;
}

}  // namespace conddp
