#include "solvers/globalization/full_step.hpp"

namespace conddp {

FullStep::FullStep(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds),
      manifold_(problem.manifold()),
      evaluation_(problem),
      gaps_(problem),
      response_(problem, bounds) {}

void FullStep::take(Evaluator& evaluator, const LinearRollout& step, Trial trial,
                    Linearization& linearization, Trajectory& trajectory,
                    const Augmentation* augmentation) {
  try_point(evaluator, step, trial, linearization, trajectory, augmentation);
}

void FullStep::correct(Evaluator& evaluator, const Feedback& feedback, Trial trial,
                       Linearization& linearization, Trajectory& trajectory,
                       const Augmentation* augmentation) {
  gaps_.set(evaluation_.gap);
  response_.respond(linearization, gaps_, feedback);
  try_point(evaluator, response_, trial, linearization, trajectory, augmentation);
}

void FullStep::try_point(Evaluator& evaluator, const LinearRollout& step, Trial trial,
                         Linearization& linearization, Trajectory& trajectory,
                         const Augmentation* augmentation) {
  step.apply(manifold_, trajectory);
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

}  // namespace conddp
