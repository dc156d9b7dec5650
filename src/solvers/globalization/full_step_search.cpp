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
  const double expected = iterate.adjoint.gap_slope() - merit.slope;
  const bool hidden = merit.hidden(expected);
  const auto costates = iterate.adjoint.costates().rightCols(iterate.trajectory.knots());
  const bool close = goal.last || hidden || goal.close;
  double weight = 0, gap = 0;
  bool small = false, ahead = false;
  // The last trial point becomes the next iterate, if it can be told to be the last.
  const auto try_point = [&](bool at_last, bool correct) {
    const Stopwatch watch(at_last ? iterate.times().differentiate : iterate.times().rollout);
    const auto trial = at_last ? FullStep::Trial::differentiate : FullStep::Trial::evaluate;
    if (at_last) iterate.hessian.begin_iterate();
    if (correct)
      step_.correct(iterate.evaluator, direction.feedback(), trial, iterate.linearization,
                    iterate.trajectory, augmentation);
    else
      step_.take(iterate.evaluator, direction.step(), trial, iterate.linearization,
                 iterate.trajectory, augmentation);
    ahead = at_last;
    iterate.linearized = iterate.linearized && !at_last;
    weight = costates.cwiseProduct(step_.gap()).lpNorm<1>();
    gap = step_.gap().lpNorm<Eigen::Infinity>();
    small = close ? gap <= tolerances_.gap : weight <= kNegligibleGaps * expected;
  };
  try_point(needs_no_correction_ && !close, false);
  needs_no_correction_ = small;
  const bool hopeless = !std::isfinite(gap) || (!hidden && weight > kHopelessGaps * expected);
  for (int corrections = 0; !small && !hopeless && corrections < kCorrections; ++corrections) {
    const double former_gap = gap;
    const double left = correction_leaves_ * (close ? gap : weight);
    try_point(left <= (close ? tolerances_.gap : kNegligibleGaps * expected), true);
    correction_leaves_ = gap / former_gap;
    if (!(gap <= kSlowCorrection * former_gap)) break;
  }
  const double actual = closed_cost - step_.cost() - costates.cwiseProduct(step_.gap()).sum();
  bool accepted = hidden ? merit.hidden(actual)
                         : actual >= kLeastDecrease * expected && weight <= kMostGaps * expected;
  if (goal.last && !(gap <= tolerances_.gap)) accepted = false;
  iterate.linearized = iterate.linearized && !accepted;
  iterate.differentiated = accepted && ahead;
  return {.accepted = accepted,
          .step = 1,
          .expected_decrease = expected,
          .actual_decrease = actual,
          .trials = 1,
          .by_rounding = hidden};
}

void FullStepSearch::reject() {
  if (last_) return;
  wanted_ *= 2;
  full_steps_ = 0;
}

}  // namespace conddp
