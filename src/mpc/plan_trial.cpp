#include "mpc/plan_trial.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/problem/by_name.hpp"

namespace conddp {

bool is_better(const TrialFigures& a, const TrialFigures& b, double tolerance) {
  const bool same = a.violation == b.violation || std::abs(a.violation - b.violation) <= tolerance;
  return same ? a.cost < b.cost : a.violation < b.violation;
}

PlanTrial::PlanTrial(const ShootingProblem& window)
    : evaluator_(window), rollout_(window), evaluation_(window) {}

TrialFigures PlanTrial::follow(const Trajectory& plan, const Feedback& feedback) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  // Step length 0 keeps the controls of the plan; the gains still act.
  evaluator_.roll_out(plan, evaluation_.gap, feedback, 0, {.clamp_controls = true}, rollout_);
  if (rollout_.first_bad_knot >= 0) return {kInfinite, kInfinite};
  evaluator_.evaluate(rollout_.trajectory, evaluation_);
  TrialFigures figures{.cost = rollout_.cost};
  for (const ConstraintViolation& found :
       violations_by_name(evaluator_.problem(), evaluation_.constraint))
    figures.violation = std::max(figures.violation, found.value);
  return figures;
}

}  // namespace conddp
