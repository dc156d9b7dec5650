#include "solvers/riccati/adjoint.hpp"

#include <algorithm>
#include <limits>

#include "ocp/evaluation/matrix_vector.hpp"
#include "solvers/riccati/regularization.hpp"

namespace conddp {

Adjoint::Adjoint(const ShootingProblem& problem, const ControlBounds& bounds)
    : bounds_(&bounds),
      costates_(Eigen::MatrixXd::Zero(problem.ndx(), problem.knots() + 1)),
      state_gradient_(costates_),
      gradient_(Eigen::VectorXd::Zero(bounds.size())),
      followed_(gradient_),
      next_(problem.ndx()),
      scratch_(problem.ndx()) {
  int largest = problem.ndx();
  for (int k = 0; k < problem.knots(); ++k)
    largest = std::max(largest, problem.ndx() + problem.nu(k));
  pulled_.resize(largest);
}

void Adjoint::compute(const Linearization& linearization, const Trajectory& trajectory,
                      const Gaps& gaps, const Feedback& feedback) {
  const int N = bounds_->knots();
  const int ndx = static_cast<int>(costates_.rows());
  costates_.col(N) = linearization.knots[N].gradient;
  gap_slope_ = 0;
  for (int k = N - 1; k >= 0; --k) {
    const KnotLinearization& knot = linearization.knots[k];
    next_ = costates_.col(k + 1);
    if (!gaps[k].closed()) {
      gap_slope_ += next_.dot(linearization.gap.col(k));
      gaps[k].pull(next_);
    }
    auto pulled = pulled_.head(ndx + knot.nu());
    knot.apply_transpose(next_, pulled, scratch_);
    auto gradient = gradient_.segment(bounds_->offset(k), knot.nu());
    gradient = knot.gradient.tail(knot.nu()) + pulled.tail(knot.nu());
    costates_.col(k) = knot.gradient.head(ndx) + pulled.head(ndx);
    auto followed = followed_.segment(bounds_->offset(k), knot.nu());
    for (int i = 0; i < knot.nu(); ++i)
      followed[i] = bounds_->at_bound(k, i, trajectory.u(k)[i]) ? 0 : gradient[i];
    auto passed_on = state_gradient_.col(k);
    multiply_transposed(feedback.K[k], followed.data(), passed_on.data());
    costates_.col(k) += passed_on;
    passed_on = -passed_on;
  }
}

double Adjoint::cost_rounding(const Linearization& linearization,
                              const Trajectory& trajectory) const {
  double scale = linearization.cost.lpNorm<1>();
  for (int k = 1; k <= bounds_->knots(); ++k) {
    scale += costates_.col(k).lpNorm<1>() * trajectory.x(k).lpNorm<Eigen::Infinity>();
  }
  return std::numeric_limits<double>::epsilon() * scale;
}

PlainAdjoint::PlainAdjoint(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      lagrangian_(problem),
      linearization_(problem),
      sweep_(problem, bounds),
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
