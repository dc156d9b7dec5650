#include "solvers/globalization/equality_search.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace conddp {
namespace {

/// Share of the penalty that covers the cost of the model's step.
constexpr double kPenaltyShare = 0.7;
/// Smallest penalty as a share of its value at the previous iterate.
constexpr double kLeastPenalty = 0.5;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

EqualitySearch::EqualitySearch(const ShootingProblem& problem)
    : problem_(problem),
      manifold_(problem.manifold()),
      lanes_(problem),
      evaluation_(problem),
      straight_(problem.create_trajectory()),
      rolled_(straight_),
      dx_(problem.ndx()) {}

/// Calls a function with the number and the residual of every row that is not free.
template <class Function>
void EqualitySearch::for_each_row(const Eigen::VectorXd& values, Function&& function) const {
  for (const NodeConstraint& c : problem_.constraints())
    for (int r = 0; r < c.term->rows; ++r)
      if (std::isfinite(c.lower[r])) function(c.row + r, values[c.row + r] - c.lower[r]);
}

double EqualitySearch::infeasibility(const Eigen::MatrixXd& gap,
                                     const Eigen::VectorXd& values) const {
  double sum = gap.lpNorm<1>();
  for_each_row(values, [&](int, double off) { sum += std::abs(off); });
  return sum;
}

void EqualitySearch::measure(const Linearization& linearization, const Trajectory& trajectory,
                             const Augmentation& augmentation, const Eigen::VectorXd& multipliers,
                             const LinearRollout& step, double curvature, MeritModel& merit) const {
  // The gradients and Hessians belong to the augmented Lagrangian. Along the step the rows go from
  // c to 0, and νᵀc and ½ ρ c² go with them.
  merit.slope = step.slope();
  for_each_row(linearization.constraint, [&](int row, double off) {
    merit.slope += multipliers[row] * off;
    curvature -= augmentation.penalty[row] * off * off;
  });
  const double model = merit.slope + 0.5 * std::max(curvature, 0.0);
  merit.penalty = kLeastPenalty * merit.penalty;
  if (merit.gap_norm > 0)
    merit.penalty = std::max(merit.penalty, model / (kPenaltyShare * merit.gap_norm));
  // Only the rollout carries rounding from knot to knot.
  double states = 0;
  for (int k = 1; k <= trajectory.knots(); ++k) states += trajectory.x(k).lpNorm<Eigen::Infinity>();
  merit.rounding = std::numeric_limits<double>::epsilon() *
                   (linearization.cost.lpNorm<1>() + merit.penalty * states);
}

void EqualitySearch::move(const LinearRollout& step, double length, const Trajectory& from) {
  straight_ = from;
  for (int k = 0; k <= from.knots(); ++k) {
    dx_ = length * step.dx(k);
    double* x = straight_.x(k).data();
    if (k > 0) manifold_.integrate(x, dx_.data(), x);
    if (k < from.knots()) straight_.u(k) += length * step.du(k);
  }
}

/// The merit of a trial, infinite for any value that is not finite.
double EqualitySearch::value(Evaluator& evaluator, const MeritModel& merit,
                             const Trajectory& trial) {
  evaluator.evaluate(trial, evaluation_);
  const double value = evaluation_.cost.sum() +
                       merit.penalty * infeasibility(evaluation_.gap, evaluation_.constraint);
  return std::isfinite(value) ? value : kInfinity;
}

LineSearchResult EqualitySearch::run(Evaluator& evaluator, const MeritModel& merit,
                                     const Linearization& linearization, const LinearRollout& step,
                                     const Feedback& feedback, double first_step,
                                     Trajectory& trajectory) {
  LineSearchResult result;
  double next_step = first_step;
  while (next_step >= kLeastStep) {
    const auto steps = lane_steps(next_step);
    evaluator.roll_out(trajectory, linearization.gap, feedback, steps.data(),
                       {.contract_gaps = true}, lanes_);
    for (int lane = 0; lane < kLaneWidth && steps[lane] >= kLeastStep; ++lane)
      if (try_lane(evaluator, merit, step, lane, steps[lane], steps[lane] == first_step, result,
                   trajectory))
        return result;
  }
  return result;
}

/// Evaluates both trials of a step length. On acceptance, the better one becomes the new iterate.
bool EqualitySearch::try_lane(Evaluator& evaluator, const MeritModel& merit,
                              const LinearRollout& step, int lane, double length, bool first,
                              LineSearchResult& result, Trajectory& trajectory) {
  ++result.trials;
  move(step, length, trajectory);
  const auto [value, trial] = better_trial(evaluator, merit, lane);
  if (value == kInfinity) {
    if (result.first_bad_knot < 0) result.first_bad_knot = lanes_.first_bad_knot[lane];
    return false;
  }
  if (!accepts(merit, length, value, first, result)) return false;
  trajectory = *trial;
  return true;
}

/// The better of the rollout in a lane and the straight step of its length: its merit and
/// trajectory.
std::pair<double, const Trajectory*> EqualitySearch::better_trial(Evaluator& evaluator,
                                                                  const MeritModel& merit,
                                                                  int lane) {
  double rolled = kInfinity;
  if (lanes_.first_bad_knot[lane] < 0) {
    lanes_.extract(lane, rolled_);
    rolled = value(evaluator, merit, rolled_);
  }
  const double straight = value(evaluator, merit, straight_);
  if (rolled <= straight) return {rolled, &rolled_};
  return {straight, &straight_};
}

/// Judges a trial by its merit.
bool EqualitySearch::accepts(const MeritModel& merit, double length, double value, bool first,
                             LineSearchResult& result) const {
  const double expected = -length * merit.merit_slope(), actual = merit.value() - value;
  if (!merit.passes(expected, actual, first)) return false;
  result.accept(length, expected, actual, merit.hidden(expected));
  return true;
}

}  // namespace conddp
