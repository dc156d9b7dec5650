#include "solvers/model_step.hpp"

namespace conddp {

ModelStep::ModelStep(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds),
      manifold_(problem.manifold()),
      evaluation_(problem),
      gaps_(problem),
      response_(problem, bounds) {}

void ModelStep::take(Acts& acts, const LinearRollout& step, Trajectory& trajectory) {
  evaluate(acts, step, trajectory);
}

void ModelStep::correct(Acts& acts, const Linearization& linearization, const Feedback& feedback,
                        Trajectory& trajectory) {
  gaps_.set(evaluation_.gap);
  response_.respond(linearization, gaps_, feedback);
  evaluate(acts, response_, trajectory);
}

void ModelStep::evaluate(Acts& acts, const LinearRollout& step, Trajectory& trajectory) {
  step.apply(manifold_, trajectory);
  bounds_.clamp(trajectory);
  acts.evaluate(trajectory, evaluation_);
}

}  // namespace conddp
