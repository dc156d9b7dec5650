#include "solvers/model_step.hpp"

namespace conddp {

ModelStep::ModelStep(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds),
      manifold_(problem.manifold()),
      evaluation_(problem),
      gaps_(problem),
      response_(problem, bounds) {}

void ModelStep::take(Acts& acts, const LinearRollout& step, Look look, Linearization& linearization,
                     Trajectory& trajectory, const Augmentation* augmentation) {
  look_at(acts, step, look, linearization, trajectory, augmentation);
}

void ModelStep::correct(Acts& acts, const Feedback& feedback, Look look,
                        Linearization& linearization, Trajectory& trajectory,
                        const Augmentation* augmentation) {
  gaps_.set(evaluation_.gap);
  response_.respond(linearization, gaps_, feedback);
  look_at(acts, response_, look, linearization, trajectory, augmentation);
}

void ModelStep::look_at(Acts& acts, const LinearRollout& step, Look look,
                        Linearization& linearization, Trajectory& trajectory,
                        const Augmentation* augmentation) {
  step.apply(manifold_, trajectory);
  bounds_.clamp(trajectory);
  if (look == Look::evaluate) {
    acts.evaluate(trajectory, evaluation_, augmentation);
    return;
  }
  acts.differentiate(trajectory, linearization, augmentation);
  evaluation_.gap = linearization.gap;
  evaluation_.cost = linearization.cost;
  evaluation_.augmentation = linearization.augmentation;
}

}  // namespace conddp
