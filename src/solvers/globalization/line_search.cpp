#include "solvers/globalization/line_search.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

double actual_decrease(double cost, double step, const MeritModel& merit) {
  return merit.cost - cost + step * merit.penalty * merit.gap_norm;
}

}  // namespace

std::array<double, kLaneWidth> lane_steps(double& next_step) {
  std::array<double, kLaneWidth> steps;
  for (double& step : steps) {
    step = next_step;
    next_step /= 2;
  }
  return steps;
}

LineSearch::LineSearch(const ShootingProblem& problem)
    : manifold_(problem.manifold()), lanes_(problem), trial_(problem), dx_(problem.ndx()) {
  int largest = 0;
  for (int k = 0; k < problem.knots(); ++k) largest = std::max(largest, problem.nu(k));
  followed_.resize(largest);
}

LineSearchResult LineSearch::run(Evaluator& evaluator, const MeritModel& merit,
                                 const Adjoint& adjoint, const Eigen::MatrixXd& gap,
                                 const Feedback& feedback, const RolloutOptions& rollout,
                                 double first_step, Trajectory& trajectory) {
  const Ray ray{merit, adjoint, gap, feedback, rollout, trajectory};
  LineSearchResult result;
  result.accepted = alone_ && try_alone(evaluator, ray, first_step, result);
  double next_step = first_step;
  while (!result.accepted && next_step >= tuning::kLeastStep)
    result.accepted = try_lanes(evaluator, ray, first_step, next_step, result);
  alone_ = result.accepted && result.step == first_step;
  if (result.accepted) std::swap(trajectory, trial_.trajectory);
  return result;
}

/// Tries the first step without comparing its half, which lowers a parabola less if the step
/// reaches a third of the first-order decrease. A step that is not convincing is left to the lanes.
bool LineSearch::try_alone(Evaluator& evaluator, const Ray& ray, double step,
                           LineSearchResult& result) {
  evaluator.roll_out(ray.from, ray.gap, ray.feedback, step, ray.rollout, trial_);
  if (trial_.first_bad_knot >= 0) return false;
  const double expected = expected_decrease(ray, step);
  const double actual = actual_decrease(trial_.cost, step, ray.merit);
  const bool hidden = ray.merit.hidden(expected);
  if (!(hidden ? ray.merit.hidden(actual) : expected > 0 && 3 * actual >= expected)) return false;
  result = {.accepted = true,
            .step = step,
            .expected_decrease = expected,
            .actual_decrease = actual,
            .trials = 1,
            .by_rounding = hidden,
            .rollout_cost = trial_.cost};
  return true;
}

/// Tries as many steps as there are lanes, from `next_step` on.
bool LineSearch::try_lanes(Evaluator& evaluator, const Ray& ray, double first_step,
                           double& next_step, LineSearchResult& result) {
  const auto steps = lane_steps(next_step);
  evaluator.roll_out(ray.from, ray.gap, ray.feedback, steps.data(), ray.rollout, lanes_);
  for (int lane = 0; lane < kLaneWidth && steps[lane] >= tuning::kLeastStep; ++lane) {
    ++result.trials;
    if (lanes_.first_bad_knot[lane] >= 0) {
      if (result.first_bad_knot < 0) result.first_bad_knot = lanes_.first_bad_knot[lane];
      continue;
    }
    if (accepts_lane(ray, lane, steps[lane], steps[lane] == first_step, result)) return true;
  }
  return false;
}

/// Judges the rollout in a lane, which is finite. On acceptance, trial_ holds it.
bool LineSearch::accepts_lane(const Ray& ray, int lane, double step, bool first,
                              LineSearchResult& result) {
  if (applies_slope(ray)) lanes_.extract(lane, trial_.trajectory);
  const double expected = expected_decrease(ray, step);
  const double actual = actual_decrease(lanes_.cost[lane], step, ray.merit);
  if (!ray.merit.passes(expected, actual, first)) return false;
  const bool hidden = ray.merit.hidden(expected);
  if (!hidden && half_is_better(lane, step / 2, actual, ray.merit)) return false;
  result.accept(step, expected, actual, hidden);
  result.rollout_cost = lanes_.cost[lane];
  lanes_.extract(lane, trial_.trajectory);
  return true;
}

/// True if the next lane, with half this step, lowers the merit more.
bool LineSearch::half_is_better(int lane, double half, double actual,
                                const MeritModel& merit) const {
  const int next = lane + 1;
  return next < kLaneWidth && half >= tuning::kShortestHalf && lanes_.first_bad_knot[next] < 0 &&
         actual_decrease(lanes_.cost[next], half, merit) > actual;
}

/// True if the expected decrease is that of the controls applied by the rollout.
bool LineSearch::applies_slope(const Ray& ray) const {
  return ray.rollout.clamp_controls && !ray.merit.slope_within_bounds;
}

/// First-order decrease of the merit; reads trial_ if applies_slope().
double LineSearch::expected_decrease(const Ray& ray, double step) {
  double slope = step * ray.merit.slope;
  if (applies_slope(ray)) {
    slope = applied_slope(ray);
    if (ray.rollout.contract_gaps) slope += step * ray.adjoint.gap_slope();
  }
  return step * ray.merit.penalty * ray.merit.gap_norm - slope;
}

double LineSearch::applied_slope(const Ray& ray) {
  const Trajectory& from = ray.from;
  const Trajectory& to = trial_.trajectory;
  double slope = 0;
  int offset = 0;
  for (int k = 0; k < from.knots(); ++k) {
    const int nu = from.nu(k);
    manifold_.difference(from.x(k).data(), to.x(k).data(), dx_.data());
    auto followed = followed_.head(nu);
    followed.noalias() = ray.feedback.K[k] * dx_;
    slope += ray.adjoint.gradient().segment(offset, nu).dot(to.u(k) - from.u(k)) -
             ray.adjoint.followed_gradient().segment(offset, nu).dot(followed);
    offset += nu;
  }
  return slope;
}

}  // namespace conddp
