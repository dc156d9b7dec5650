#include "solvers/globalization/full_step_search.hpp"

#include <cmath>

#include "base/stopwatch.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {

FullStep::FullStep(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds),
      manifold_(problem.manifold()),
      evaluation_(problem),
      gaps_(problem),
      response_(problem, bounds) {}

void FullStep::correct(Evaluator& evaluator, const Feedback& feedback, Trial trial,
                       Linearization& linearization, Trajectory& trajectory,
                       const Augmentation* augmentation) {
  gaps_.set(evaluation_.gap);
  response_.respond(linearization, gaps_, feedback);
  take(evaluator, response_, trial, linearization, trajectory, augmentation);
}

void FullStep::take(Evaluator& evaluator, const LinearRollout& step, Trial trial,
                    Linearization& linearization, Trajectory& trajectory,
                    const Augmentation* augmentation) {
  step.apply(manifold_, 1, trajectory);
  bounds_.clamp(trajectory);
  if (trial == Trial::evaluate) {
    evaluator.evaluate(trajectory, evaluation_, augmentation);
    return;
  }
  evaluator.differentiate(trajectory, linearization, augmentation);
  evaluation_.gap = linearization.gap;
  evaluation_.cost = linearization.cost;
  evaluation_.augmentation = linearization.augmentation;
}

FullStepSearch::FullStepSearch(const ShootingProblem& problem, const ControlBounds& bounds,
                               const SolverOptions::Tolerances& tolerances)
    : tolerances_(tolerances), step_(problem, bounds) {}

void FullStepSearch::reset() {
  full_steps_ = 0;
  wanted_ = 1;
  needs_no_correction_ = false;
  correction_leaves_ = 1;
}

LineSearchResult FullStepSearch::run(Iterate& iterate, const MeritModel& merit,
                                     const Direction& direction, const Augmentation* augmentation,
                                     const Goal& goal) {
  last_ = goal.last;
  const double closed_cost = merit.cost + iterate.adjoint.gap_slope();
  Search search = begin(iterate, merit, direction, augmentation, goal);
  try_point(search, needs_no_correction_ && !search.close, false);
  needs_no_correction_ = search.gaps_negligible();
  correct(search);
  const double actual =
      closed_cost - step_.cost() - search.costates().cwiseProduct(step_.gap()).sum();
  const bool accepted =
      (!goal.last || search.gap <= tolerances_.gap) && search.suffices(actual, merit);
  iterate.linearized = iterate.linearized && !accepted;
  iterate.differentiated = accepted && search.ahead;
  return {.accepted = accepted,
          .step = 1,
          .expected_decrease = search.expected,
          .actual_decrease = actual,
          .trials = 1,
          .by_rounding = search.hidden};
}

FullStepSearch::Search FullStepSearch::begin(Iterate& iterate, const MeritModel& merit,
                                             const Direction& direction,
                                             const Augmentation* augmentation,
                                             const Goal& goal) const {
  Search search{.iterate = iterate, .direction = direction, .augmentation = augmentation};
  search.expected = iterate.adjoint.gap_slope() - merit.slope;
  search.hidden = merit.hidden(search.expected);
  search.close = goal.last || search.hidden || goal.close;
  search.negligible = search.close ? tolerances_.gap : tuning::kNegligibleGaps * search.expected;
  return search;
}

bool FullStepSearch::Search::suffices(double actual, const MeritModel& merit) const {
  if (hidden) return merit.hidden(actual);
  return actual >= tuning::kArmijo * expected && weight <= tuning::kMostGaps * expected;
}

/// Takes the step or corrects the last trial. A trial that is predictably the last one is
/// differentiated at once, because it becomes the next iterate.
void FullStepSearch::try_point(Search& search, bool at_last, bool correct) {
  Iterate& iterate = search.iterate;
  const Stopwatch watch(at_last ? iterate.times().differentiate : iterate.times().rollout);
  const auto trial = at_last ? FullStep::Trial::differentiate : FullStep::Trial::evaluate;
  if (at_last) iterate.hessian.begin_iterate();
  if (correct)
    step_.correct(iterate.evaluator, search.direction.feedback(), trial, iterate.linearization,
                  iterate.trajectory, search.augmentation);
  else
    step_.take(iterate.evaluator, search.direction.step(), trial, iterate.linearization,
               iterate.trajectory, search.augmentation);
  search.ahead = at_last;
  iterate.linearized = iterate.linearized && !at_last;
  search.weight = search.costates().cwiseProduct(step_.gap()).lpNorm<1>();
  search.gap = step_.gap().lpNorm<Eigen::Infinity>();
}

/// Corrects until the gaps are negligible, as long as this seems possible.
void FullStepSearch::correct(Search& search) {
  if (!std::isfinite(search.gap)) return;
  for (int i = 0; i < tuning::kCorrections && !search.gaps_negligible(); ++i) {
    const double former_gap = search.gap;
    const double left = correction_leaves_ * search.size();
    try_point(search, left <= search.negligible, true);
    correction_leaves_ = search.gap / former_gap;
    if (!(search.gap <= tuning::kProgress * former_gap)) break;
  }
}

void FullStepSearch::reject() {
  if (last_) return;
  wanted_ *= 2;
  full_steps_ = 0;
}

}  // namespace conddp
