#include "solvers/riccati/plain_adjoint.hpp"

#include <algorithm>

#include "solvers/riccati/regularization.hpp"

namespace conddp {

PlainAdjoint::PlainAdjoint(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      lagrangian_(problem),
      linearization_(problem),
      sweep_(problem, bounds, {}),
      stages_(unconstrained_stage(problem)),
      feedback_(problem),
      adjoint_(problem, bounds) {
  for (const KnotLinearization& knot : linearization_.knots)
    cost_gradients_.push_back(knot.gradient);
}

std::optional<double> PlainAdjoint::stationarity(Evaluator& evaluator, const Trajectory& trajectory,
                                                 const Gaps& gaps,
                                                 const Eigen::VectorXd& multipliers) {
  lagrangian_.multiplier = multipliers;
  evaluator.differentiate(trajectory, linearization_, &lagrangian_);
  cost_gradient_ = largest_cost_gradient();
  RegularizationSchedule schedule;
  while (sweep_.run(linearization_, trajectory, gaps, schedule.value(), *stages_, feedback_) >= 0)
    if (!schedule.increase()) return std::nullopt;
  adjoint_.compute(linearization_, trajectory, gaps, feedback_);
  return bounds_.projected_norm(adjoint_.gradient(), trajectory).value;
}

/// Largest entry of the cost's gradients, without the contribution of hard constraints.
double PlainAdjoint::largest_cost_gradient() {
  for (std::size_t k = 0; k < cost_gradients_.size(); ++k)
    cost_gradients_[k] = linearization_.knots[k].gradient;
  for (const NodeConstraint& c : problem_.constraints()) {
    if (c.is_soft()) continue;
    const auto C = linearization_.knots[c.node].C.middleRows(
        c.row - problem_.constraint_offset(c.node), c.term->rows);
    cost_gradients_[c.node].noalias() -=
        C.transpose() * lagrangian_.multiplier.segment(c.row, c.term->rows);
  }
  double largest = 0;
  for (const Eigen::VectorXd& gradient : cost_gradients_)
    largest = std::max(largest, gradient.lpNorm<Eigen::Infinity>());
  return largest;
}

}  // namespace conddp
