#include "solvers/globalization/full_step_search.hpp"

#include <cmath>

#include "base/stopwatch.hpp"

namespace conddp {
namespace {

/// Shares of the expected decrease that a step has to reach, that its gaps, weighted by their
/// multipliers, may reach, and up to which they are left as they are.
constexpr double kLeastDecrease = 0.1;
constexpr double kMostGaps = 0.5;
constexpr double kNegligibleGaps = 0.05;
/// The same share from which on a rollout is the shorter way, and the share of the gaps that a
/// correction may leave.
constexpr double kHopelessGaps = 10;
constexpr double kSlowCorrection = 0.5;
constexpr int kCorrections = 3;
/// What a correction is taken to leave of the gaps before one has been seen.
constexpr double kFirstCorrection = 1;

}  // namespace

FullStepSearch::FullStepSearch(const ShootingProblem& problem, const ControlBounds& bounds,
                               const SolverOptions::Tolerances& tolerances)
    : tolerances_(tolerances), step_(problem, bounds) {}

void FullStepSearch::reset() {
  full_steps_ = 0;
  wanted_ = 1;
  needs_no_correction_ = false;
  correction_leaves_ = kFirstCorrection;
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
  search.negligible = search.close ? tolerances_.gap : kNegligibleGaps * search.expected;
  return search;
}

bool FullStepSearch::Search::hopeless() const {
  return !std::isfinite(gap) || (!hidden && weight > kHopelessGaps * expected);
}

bool FullStepSearch::Search::suffices(double actual, const MeritModel& merit) const {
  if (hidden) return merit.hidden(actual);
  return actual >= kLeastDecrease * expected && weight <= kMostGaps * expected;
}

/// Takes the step or corrects the last trial. The trial is differentiated at once if it can be told
/// to be the last one: it becomes the next iterate.
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

/// Corrections until the gaps are negligible, as long as there is hope.
void FullStepSearch::correct(Search& search) {
  if (search.hopeless()) return;
  for (int i = 0; i < kCorrections && !search.gaps_negligible(); ++i) {
    const double former_gap = search.gap;
    const double left = correction_leaves_ * search.size();
    try_point(search, left <= search.negligible, true);
    correction_leaves_ = search.gap / former_gap;
    if (!(search.gap <= kSlowCorrection * former_gap)) break;
  }
}

void FullStepSearch::reject() {
  if (last_) return;
  wanted_ *= 2;
  full_steps_ = 0;
}

}  // namespace conddp
