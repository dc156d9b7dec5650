#include "solvers/constraints/answer_gains.hpp"

#include <algorithm>

#include "solvers/common/finite_check.hpp"
#include "solvers/common/tuning.hpp"
#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/riccati/regularization.hpp"
#include "solvers/stages/stage_solver.hpp"

namespace conddp {

AnswerGains gains_at(const ShootingProblem& problem, const ControlBounds& bounds,
                     Evaluator& evaluator, const Trajectory& trajectory,
                     const Eigen::VectorXd& multipliers) {
  AnswerGains answer{Feedback(problem), {}, {}};
  Linearization linearization(problem);
  evaluator.differentiate(trajectory, linearization);
  Augmentation augmentation(problem);
  for (const NodeConstraint& c : problem.constraints())
    augmentation.penalty.segment(c.row, c.term->rows)
        .setConstant(std::max(tuning::kLeastCurvature,
                              linearization.knots[c.node].hessian().diagonal().maxCoeff()));
  answer.penalty = augmentation.penalty.cwiseMax(tuning::kLeastCurvature);
  augmentation.shift = multipliers.cwiseQuotient(answer.penalty);
  evaluator.differentiate(trajectory, linearization, &augmentation);
  if (find_non_finite(linearization)) return answer;
  Gaps gaps(problem);
  gaps.set(linearization, true);
  BackwardSweep sweep(problem, bounds);
  const auto stages = box_stage(problem);
  RegularizationSchedule schedule;
  do {
    if (sweep.run(linearization, trajectory, gaps, schedule.value(), *stages, answer.feedback) >= 0)
      continue;
    answer.regularization = schedule.value();
    return answer;
  } while (schedule.increase());
  answer.feedback.set_zero();
  return answer;
}

}  // namespace conddp
