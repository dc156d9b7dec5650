#include "solvers/globalization/open_gap_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace conddp {
namespace {

/// Share of the gaps' weight that covers the cost of the model's step; the rest is decrease.
constexpr double kGapShare = 0.65;
/// A rollout that reaches this share of the model's decrease makes another trial unnecessary.
constexpr double kConvincing = 0.6;
/// Largest allowed growth of the gaps by a linear step. If the model's cost falls with its gaps,
/// their weight is zero, and nothing else limits them.
constexpr double kMostGapGrowth = 1.5;

}  // namespace

OpenGapSearch::OpenGapSearch(const ShootingProblem& problem, const ControlBounds& bounds,
                             bool clamp_controls)
    : bounds_(bounds),
      manifold_(problem.manifold()),
      clamp_controls_(clamp_controls),
      best_(problem.create_trajectory()),
      trial_(problem.create_trajectory()),
      rollout_(problem),
      evaluation_(problem),
      dx_(problem.ndx()) {}

double OpenGapSearch::weigh(const MeritModel& merit, double curvature) {
  curvature_ = std::max(curvature, 0.0);
  return std::max(merit.slope + 0.5 * curvature_, 0.0) / (kGapShare * merit.gap_norm);
}

LineSearchResult OpenGapSearch::run(Evaluator& evaluator, const MeritModel& merit,
                                    const Linearization& linearization, const Direction& direction,
                                    const Augmentation* augmentation, Trajectory& trajectory) {
  LineSearchResult result;
  for (double step = 1; step >= kLeastStep; step /= 2) {
    const double expected = -step * merit.merit_slope();
    best_decrease_ = -std::numeric_limits<double>::infinity();
    ++result.trials;
    try_rollout(evaluator, merit, linearization, direction, augmentation, step, trajectory);
    if (!(best_decrease_ >= kConvincing * (expected - 0.5 * step * step * curvature_))) {
      ++result.trials;
      try_linear(evaluator, merit, direction, augmentation, step, trajectory);
    }
    if (!(expected > 0 && best_decrease_ >= kArmijo * expected)) continue;
    result.accept(step, expected, best_decrease_, false);
    result.rollout_cost = best_rollout_cost_;
    std::swap(trajectory, best_);
    return result;
  }
  return result;
}

/// Keeps a trial if it is the best of its step length. True if it is.
bool OpenGapSearch::consider(double cost, double gap_norm, const MeritModel& merit,
                             Trajectory& trial) {
  const double decrease = merit.value() - (cost + merit.penalty * gap_norm);
  if (!std::isfinite(decrease) || decrease <= best_decrease_) return false;
  best_decrease_ = decrease;
  std::swap(best_, trial);
  return true;
}

void OpenGapSearch::try_rollout(Evaluator& evaluator, const MeritModel& merit,
                                const Linearization& linearization, const Direction& direction,
                                const Augmentation* augmentation, double step,
                                const Trajectory& from) {
  evaluator.roll_out(
      from, linearization.gap, direction.feedback(), step,
      {.contract_gaps = true, .clamp_controls = clamp_controls_, .augmentation = augmentation},
      rollout_);
  if (rollout_.first_bad_knot >= 0) return;
  if (consider(rollout_.cost, (1 - step) * merit.gap_norm, merit, rollout_.trajectory))
    best_rollout_cost_ = rollout_.cost;
}

void OpenGapSearch::try_linear(Evaluator& evaluator, const MeritModel& merit,
                               const Direction& direction, const Augmentation* augmentation,
                               double step, const Trajectory& from) {
  trial_ = from;
  for (int k = 0; k <= from.knots(); ++k) {
    if (k > 0) {
      dx_ = step * direction.step().dx(k);
      manifold_.integrate(from.x(k).data(), dx_.data(), trial_.x(k).data());
    }
    if (k < from.knots()) trial_.u(k) += step * direction.step().du(k);
  }
  bounds_.clamp(trial_);
  evaluator.evaluate(trial_, evaluation_, augmentation);
  const double gap_norm = evaluation_.gap.lpNorm<1>();
  if (gap_norm > kMostGapGrowth * merit.gap_norm) return;
  if (consider(evaluation_.cost.sum() + evaluation_.augmentation.sum(), gap_norm, merit, trial_))
    best_rollout_cost_.reset();
}

}  // namespace conddp
