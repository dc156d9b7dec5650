#include "solvers/globalization/open_gap_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "solvers/common/tuning.hpp"

namespace conddp {

OpenGapSearch::OpenGapSearch(const ShootingProblem& problem, const ControlBounds& bounds,
                             bool clamp_controls, bool rows)
    : problem_(problem),
      bounds_(bounds),
      clamp_controls_(clamp_controls),
      rows_(rows),
      best_(problem.create_trajectory()),
      trial_(problem.create_trajectory()),
      rollout_(problem),
      evaluation_(problem) {}

/// Calls a function with the number and the gap of every enforced row that is not free.
template <class Function>
void OpenGapSearch::for_each_row(const Eigen::VectorXd& values, Function&& function) const {
  if (!rows_) return;
  for (const NodeConstraint& c : problem_.constraints())
    for (int r = 0; r < c.term->rows; ++r)
      if (std::isfinite(c.lower[r])) function(c.row + r, values[c.row + r] - c.lower[r]);
}

double OpenGapSearch::gap_norm(const Eigen::MatrixXd& gap, const Eigen::VectorXd& values) const {
  double sum = gap.lpNorm<1>();
  for_each_row(values, [&](int, double off) { sum += std::abs(off); });
  return sum;
}

void OpenGapSearch::leave_out(const Augmentation& augmentation, const Eigen::VectorXd& multipliers,
                              const Eigen::VectorXd& values, double& slope,
                              double& curvature) const {
  for_each_row(values, [&](int row, double off) {
    slope += multipliers[row] * off;
    curvature -= augmentation.penalty[row] * off * off;
  });
}

double OpenGapSearch::weigh(const MeritModel& merit, double curvature) {
  curvature_ = std::max(curvature, 0.0);
  if (!(merit.gap_norm > 0)) return 0;
  return std::max(merit.slope + 0.5 * curvature_, 0.0) / (tuning::kGapShare * merit.gap_norm);
}

LineSearchResult OpenGapSearch::run(Evaluator& evaluator, const MeritModel& merit,
                                    const Linearization& linearization, const Direction& direction,
                                    const Augmentation* augmentation, double first_step,
                                    Trajectory& trajectory) {
  const Search search{evaluator, merit, linearization, direction, augmentation, trajectory};
  LineSearchResult result;
  for (double step = first_step; step >= tuning::kLeastStep; step /= 2) {
    const double expected = -step * merit.merit_slope();
    best_decrease_ = -std::numeric_limits<double>::infinity();
    try_rollout(search, step, result);
    if (!(best_decrease_ >= tuning::kConvincing * (expected - 0.5 * step * step * curvature_))) {
      ++result.trials;
      try_linear(search, step);
    }
    if (!merit.passes(expected, best_decrease_, step == first_step)) continue;
    result.accept(step, expected, best_decrease_, merit.hidden(expected));
    result.rollout_cost = best_rollout_cost_;
    std::swap(trajectory, best_);
    return result;
  }
  return result;
}

void OpenGapSearch::try_rollout(const Search& search, double step, LineSearchResult& result) {
  ++result.trials;
  search.evaluator.roll_out(search.from, search.linearization.gap, search.direction.feedback(),
                            step,
                            {.contract_gaps = true,
                             .clamp_controls = clamp_controls_,
                             .augmentation = search.augmentation},
                            rollout_);
  if (rollout_.first_bad_knot >= 0) {
    if (result.first_bad_knot < 0) result.first_bad_knot = rollout_.first_bad_knot;
    return;
  }
  const bool best =
      rows_ ? consider(search, rollout_.trajectory, std::numeric_limits<double>::infinity())
            : consider(search.merit, rollout_.cost, (1 - step) * search.merit.gap_norm,
                       rollout_.trajectory);
  if (best) best_rollout_cost_ = rollout_.cost;
}

void OpenGapSearch::try_linear(const Search& search, double step) {
  trial_ = search.from;
  search.direction.step().apply(problem_.manifold(), step, trial_);
  bounds_.clamp(trial_);
  if (consider(search, trial_, tuning::kMostGapGrowth * search.merit.gap_norm))
    best_rollout_cost_.reset();
}

bool OpenGapSearch::consider(const Search& search, Trajectory& trial, double most_gaps) {
  search.evaluator.evaluate(trial, evaluation_, search.augmentation);
  const double gaps = gap_norm(evaluation_.gap, evaluation_.constraint);
  return gaps <= most_gaps &&
         consider(search.merit, evaluation_.cost.sum() + evaluation_.augmentation.sum(), gaps,
                  trial);
}

bool OpenGapSearch::consider(const MeritModel& merit, double cost, double gap_norm,
                             Trajectory& trial) {
  const double decrease = merit.value() - (cost + merit.penalty * gap_norm);
  if (!std::isfinite(decrease) || decrease <= best_decrease_) return false;
  best_decrease_ = decrease;
  std::swap(best_, trial);
  return true;
}

}  // namespace conddp
