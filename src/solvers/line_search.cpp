#include "solvers/line_search.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

/// How many times its estimated rounding a merit has to change for Armijo's rule to see it.
constexpr double kVisible = 10;
/// Down to this length an acceptable step gives way to its half if that lowers the merit more.
constexpr double kShortestCompared = 0.125;

}  // namespace

bool MeritModel::hidden(double change) const { return std::abs(change) <= kVisible * rounding; }

LineSearch::LineSearch(const ShootingProblem& problem, const SolverOptions::LineSearch& options)
    : options_(options),
      manifold_(problem.manifold()),
      lanes_(problem),
      trial_(problem.create_trajectory()),
      dx_(problem.ndx()) {
  int largest = 0;
  for (int k = 0; k < problem.knots(); ++k) largest = std::max(largest, problem.nu(k));
  followed_.resize(largest);
}

double LineSearch::applied_slope(int lane, const Adjoint& adjoint, const Feedback& feedback,
                                 const Trajectory& trajectory) {
  lanes_.extract(lane, trial_);
  double slope = 0;
  int offset = 0;
  for (int k = 0; k < trajectory.knots(); ++k) {
    const int nu = trajectory.nu(k);
    manifold_.difference(trajectory.x(k).data(), trial_.x(k).data(), dx_.data());
    auto followed = followed_.head(nu);
    followed.noalias() = feedback.K[k] * dx_;
    slope += adjoint.gradient().segment(offset, nu).dot(trial_.u(k) - trajectory.u(k)) -
             adjoint.followed_gradient().segment(offset, nu).dot(followed);
    offset += nu;
  }
  return slope;
}

LineSearchResult LineSearch::run(Acts& acts, const MeritModel& merit, const Adjoint& adjoint,
                                 const Eigen::MatrixXd& gap, const Feedback& feedback,
                                 const RolloutOptions& rollout, double first_step,
                                 Trajectory& trajectory) {
  LineSearchResult result;
  double next_step = first_step;
  while (next_step >= options_.min_step) {
    double steps[kLaneWidth];
    for (double& step : steps) {
      step = next_step;
      next_step /= 2;
    }
    acts.roll_out(trajectory, gap, feedback, steps, rollout, lanes_);
    for (int lane = 0; lane < kLaneWidth && steps[lane] >= options_.min_step; ++lane) {
      ++result.trials;
      if (lanes_.first_bad_knot[lane] >= 0) {
        if (result.first_bad_knot < 0) result.first_bad_knot = lanes_.first_bad_knot[lane];
        continue;
      }
      const double step = steps[lane];
      const double expected =
          expected_decrease(lane, step, merit, adjoint, feedback, rollout, trajectory);
      const double actual = actual_decrease(lane, step, merit);
      const bool hidden = merit.hidden(expected);
      const bool armijo = expected > 0 && actual >= options_.armijo * expected;
      if (!armijo && !(hidden && step == first_step && merit.hidden(actual))) continue;
      if (!hidden && lane + 1 < kLaneWidth && steps[lane + 1] >= kShortestCompared &&
          lanes_.first_bad_knot[lane + 1] < 0 &&
          actual_decrease(lane + 1, steps[lane + 1], merit) > actual) {
        continue;
      }
      result.accepted = true;
      result.by_rounding = hidden;
      result.step = step;
      result.expected_decrease = expected;
      result.actual_decrease = actual;
      lanes_.extract(lane, trajectory);
      return result;
    }
  }
  return result;
}

double LineSearch::actual_decrease(int lane, double step, const MeritModel& merit) const {
  return merit.cost - lanes_.cost[lane] + step * merit.penalty * merit.gap_norm;
}

double LineSearch::expected_decrease(int lane, double step, const MeritModel& merit,
                                     const Adjoint& adjoint, const Feedback& feedback,
                                     const RolloutOptions& rollout, const Trajectory& trajectory) {
  double slope = step * merit.slope;
  if (rollout.clamp_controls && !merit.slope_within_bounds) {
    slope = applied_slope(lane, adjoint, feedback, trajectory);
    if (rollout.contract_gaps) slope += step * adjoint.gap_slope();
  }
  return step * merit.penalty * merit.gap_norm - slope;
}

}  // namespace conddp
