#include "solvers/hessian_switch.hpp"

#include <cmath>

namespace conddp {
namespace {

/// Iterations over which convergence is judged to be slow or not.
constexpr int kWatchedIterations = 10;

}  // namespace

HessianUse hessian_use(const SolverOptions& options) {
  switch (options.hessian) {
    case HessianChoice::gauss_newton:
      return HessianUse::gauss_newton;
    case HessianChoice::exact:
      return HessianUse::exact;
    case HessianChoice::automatic:
      break;
  }
  return HessianUse::when_slow;
}

HessianSwitch::HessianSwitch(HessianUse use, Acts& acts, Linearization& linearization)
    : use_(use), acts_(acts), linearization_(linearization) {
  if (use == HessianUse::gauss_newton) return;
  acts.reserve_lagrangian_hessian();
  for (const KnotLinearization& knot : linearization.knots) other_.push_back(knot.hessian);
}

void HessianSwitch::reset() { exact_wanted_ = use_ == HessianUse::exact; }

/// Every kWatchedIterations: neither has the stationarity fallen by a factor of ten, nor is the
/// cost still falling much; then Gauss-Newton is in the slow tail of its convergence.
void HessianSwitch::watch(const IterationRecord& row) {
  if (use_ != HessianUse::when_slow || exact_wanted_) return;
  if (row.iteration > 0 && row.iteration < watched_iteration_ + kWatchedIterations) return;
  exact_wanted_ = row.iteration > 0 && row.stationarity > 0.1 * watched_stationarity_ &&
                  watched_cost_ - row.cost < 0.1 * std::abs(row.cost);
  watched_iteration_ = row.iteration;
  watched_stationarity_ = row.stationarity;
  watched_cost_ = row.cost;
}

bool HessianSwitch::turn() {
  if (use_ != HessianUse::when_slow || exact_wanted_) return false;
  exact_wanted_ = true;
  return true;
}

void HessianSwitch::begin_iterate() {
  use(false);
  exact_known_ = false;
}

void HessianSwitch::evaluate_exact(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                                   const Augmentation* augmentation) {
  use(true);
  acts_.lagrangian_hessian(trajectory, costates, linearization_, augmentation);
  exact_known_ = true;
}

void HessianSwitch::use(bool exact) {
  if (exact == exact_in_use_) return;
  for (std::size_t k = 0; k < other_.size(); ++k) {
    linearization_.knots[k].hessian.swap(other_[k]);
  }
  exact_in_use_ = exact;
}

}  // namespace conddp
