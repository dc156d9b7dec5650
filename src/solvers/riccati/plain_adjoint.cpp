#include "solvers/riccati/plain_adjoint.hpp"

#include "solvers/riccati/regularization.hpp"

namespace conddp {

PlainAdjoint::PlainAdjoint(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(bounds),
      lagrangian_(problem),
      linearization_(problem),
      sweep_(problem, bounds, {}),
      stages_(unconstrained_stage(problem)),
      feedback_(problem),
      adjoint_(problem, bounds) {}

std::optional<double> PlainAdjoint::stationarity(
    Evaluator& evaluator, const Trajectory& trajectory, const Gaps& gaps,
    const SolverOptions::Regularization& regularization, const Eigen::VectorXd& multipliers) {
  lagrangian_.multiplier = multipliers;
  evaluator.differentiate(trajectory, linearization_, &lagrangian_);
  SolverOptions::Regularization from_zero = regularization;
  from_zero.initial = 0;
  RegularizationSchedule schedule(from_zero);
  while (sweep_.run(linearization_, trajectory, gaps, {regularization.kind, schedule.value()},
                    *stages_, feedback_) >= 0) {
    if (!schedule.increase()) return std::nullopt;
  }
  adjoint_.compute(linearization_, trajectory, gaps, feedback_);
  return bounds_.projected_norm(adjoint_.gradient(), trajectory).value;
}

}  // namespace conddp
