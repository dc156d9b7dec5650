#include "solvers/iterate/hessian_switch.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

/// Doublings of the window, which keep it within an int.
constexpr int kMostDoublings = 10;

bool has_linear_costs(const Phase& phase) {
  const std::vector<CostTerm>& costs = phase.model->costs();
  return std::any_of(costs.begin(), costs.end(), [](const CostTerm& cost) {
    return cost.activation.kind == ActivationKind::linear;
  });
}

}  // namespace

bool has_linear_costs(const ShootingProblem& problem) {
  return has_linear_costs(problem.terminal()) ||
         std::any_of(problem.phases().begin(), problem.phases().end(),
                     [](const Phase& phase) { return has_linear_costs(phase); });
}

bool exact_hessians_are_dear(const ShootingProblem& problem) {
  int directions = 0;
  for (int k = 0; k < problem.knots(); ++k)
    directions = std::max(directions, problem.knot(k).model->nz());
  return directions >= tuning::kDearDirections;
}

HessianUse hessian_use(HessianUse use, const SolverOptions& options,
                       const ShootingProblem& problem) {
  if (use == HessianUse::when_slow && options.hessian == HessianChoice::gauss_newton)
    return HessianUse::gauss_newton;
  if (use != HessianUse::gauss_newton && has_linear_costs(problem)) return HessianUse::exact_alone;
  if (use == HessianUse::when_slow && options.hessian == HessianChoice::exact)
    return HessianUse::exact;
  return use;
}

bool same_hessian(const Eigen::MatrixXd& a, const Eigen::MatrixXd& b) {
  double largest = 0, apart = 0;
  for (Eigen::Index i = 0; i < a.size(); ++i) {
    largest = std::max(largest, std::abs(a.data()[i]));
    apart = std::max(apart, std::abs(a.data()[i] - b.data()[i]));
  }
  return apart <= tuning::kRounding * largest;
}

HessianSwitch::HessianSwitch(HessianUse use, double tolerance, Evaluator& evaluator,
                             Linearization& linearization)
    : use_(use), tolerance_(tolerance), evaluator_(evaluator), linearization_(linearization) {
  if (use == HessianUse::gauss_newton) return;
  Eigen::Index nz = 0;
  for (const KnotLinearization& knot : linearization.knots) nz = std::max(nz, knot.gradient.size());
  exact_cost_ = 1 + static_cast<double>(nz);
  if (use != HessianUse::when_slow) reserve();
}

void HessianSwitch::reserve() {
  if (use_ == HessianUse::gauss_newton || !other_.empty()) return;
  evaluator_.reserve_lagrangian_hessian();
  costates_.resize(linearization_.gap.rows(), linearization_.gap.cols() + 1);
  other_.reserve(linearization_.knots.size());
  for (const KnotLinearization& knot : linearization_.knots) other_.push_back(knot.hessian());
}

void HessianSwitch::reset() {
  exact_wanted_ = use_ == HessianUse::exact || exact_alone();
  for_good_ = same_ = false;
  returns_ = 0;
}

/// Iterations over which the convergence of the current Hessians is judged. The window of
/// Gauss-Newton Hessians doubles whenever exact ones have been given up.
int HessianSwitch::window() const {
  if (exact_wanted_)
    return std::max(tuning::kFewestExact, static_cast<int>(tuning::kExactTrial / exact_cost_));
  return std::max(tuning::kWatchedIterations, static_cast<int>(exact_cost_ / 2))
         << std::min(returns_, kMostDoublings);
}

/// An exact Hessian takes a pass for each direction, so its savings must be worth that. The window
/// is no longer than a fraction of this price. Over it, the convergence rate of stationarity
/// predicts how many iterations Gauss-Newton still needs; exact Hessians are assumed to need
/// kExactIterations. While the cost falls substantially, that rate is meaningless.
bool HessianSwitch::gauss_newton_is_slow(const IterationRecord& row) const {
  if (watched_cost_ - row.cost >= tuning::kTighter * std::abs(row.cost)) return false;
  const double decades = std::log10(watched_stationarity_ / row.stationarity) / window();
  const double wanted = std::log10(row.stationarity / tolerance_);
  return !(wanted <= decades * tuning::kExactIterations * exact_cost_);
}

/// Far from an optimum, exact Hessians are as slow as others. They stay if, at their rate, they
/// need at most as many further iterations as they have taken.
bool HessianSwitch::exact_is_slow(const IterationRecord& row) const {
  return !(std::log10(row.stationarity / tolerance_) <=
           std::log10(watched_stationarity_ / row.stationarity));
}

void HessianSwitch::watch(const IterationRecord& row) {
  if (use_ != HessianUse::when_slow || for_good_) return;
  if (row.iteration > 0) {
    if (row.iteration < watched_iteration_ + window()) return;
    turn_if_slow(row);
  }
  watched_iteration_ = row.iteration;
  watched_stationarity_ = row.stationarity;
  watched_cost_ = row.cost;
}

/// Turns to the other Hessians at the end of a window if those in use are slow.
void HessianSwitch::turn_if_slow(const IterationRecord& row) {
  const bool slow = exact_wanted_ ? exact_is_slow(row) : gauss_newton_is_slow(row);
  if (!slow) return;
  if (exact_wanted_) ++returns_;
  exact_wanted_ = !exact_wanted_;
}

bool HessianSwitch::turn() {
  if (use_ != HessianUse::when_slow || exact_wanted_ || same_) return false;
  exact_wanted_ = for_good_ = true;
  return true;
}

void HessianSwitch::begin_iterate() {
  use(false);
  exact_known_ = false;
}

void HessianSwitch::evaluate_exact(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                                   const Augmentation* augmentation) {
  reserve();
  use(true);
  evaluator_.lagrangian_hessian(trajectory, costates, linearization_, augmentation);
  costates_ = costates;
  exact_known_ = true;
  if (use_ != HessianUse::when_slow) return;
  same_ = true;
  for (std::size_t k = 0; k < other_.size() && same_; ++k)
    same_ = same_hessian(linearization_.knots[k].hessian(), other_[k]);
  if (!same_) return;
  use(false);
  exact_known_ = exact_wanted_ = false;
}

void HessianSwitch::follow(const Trajectory& trajectory, const Eigen::MatrixXd& costates,
                           const Augmentation* augmentation) {
  if (exact_known_ && costates != costates_) evaluate_exact(trajectory, costates, augmentation);
}

void HessianSwitch::use(bool exact) {
  if (exact == exact_in_use_) return;
  for (std::size_t k = 0; k < other_.size(); ++k) {
    linearization_.knots[k].hessian.change().swap(other_[k]);
  }
  exact_in_use_ = exact;
}

}  // namespace conddp
