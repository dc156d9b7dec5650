#include "solvers/constraints/violation_slope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/problem/soft_constraint.hpp"

namespace conddp {
namespace {

/// Multipliers per distance: the difference that they make to the cost's gradient keeps its digits.
constexpr double kWeight = 1e10;

/// The largest size of a control anywhere, at least 1.
double largest_control(const Trajectory& trajectory) {
  double largest = 1;
  for (int k = 0; k < trajectory.knots(); ++k)
    if (trajectory.u(k).size() > 0)
      largest = std::max(largest, trajectory.u(k).lpNorm<Eigen::Infinity>());
  return largest;
}

}  // namespace

ViolationSlope::ViolationSlope(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      distances_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      lagrangian_(problem),
      linearization_(problem),
      no_feedback_(problem),
      adjoint_(problem, bounds) {}

double ViolationSlope::violation(const Eigen::VectorXd& values) {
  for (const NodeConstraint& c : problem_.constraints())
    if (!c.is_soft()) next_multipliers(c, values.data() + c.row, 1, distances_.data() + c.row);
  return distances_.norm();
}

double ViolationSlope::share(Evaluator& evaluator, const Trajectory& trajectory, const Gaps& gaps) {
  const auto gradient = [&](const Eigen::VectorXd& multipliers) -> Eigen::VectorXd {
    lagrangian_.multiplier = multipliers;
    evaluator.differentiate(trajectory, linearization_, &lagrangian_);
    adjoint_.compute(linearization_, trajectory, gaps, no_feedback_);
    return adjoint_.gradient();
  };
  // The cost's own part is taken out, however small its share: where a penalty's minimum was found
  // it cancels what is asked for.
  const Eigen::VectorXd of_cost = gradient(Eigen::VectorXd::Zero(distances_.size()));
  const Eigen::VectorXd with_distances = gradient(kWeight * distances_);
  return share((with_distances - of_cost) / kWeight, trajectory);
}

double ViolationSlope::share(const Eigen::VectorXd& gradient, const Trajectory& trajectory) const {
  const double most = largest_control(trajectory);
  double sum = 0;
  for (int k = 0; k < bounds_.knots(); ++k) {
    const auto lower = bounds_.lower(k), upper = bounds_.upper(k);
    for (Eigen::Index i = 0; i < lower.size(); ++i) {
      const double slope = gradient[bounds_.offset(k) + i], u = trajectory.u(k)[i];
      const double way = slope > 0 ? u - lower[i] : upper[i] - u;
      sum += std::abs(slope) * (std::isfinite(way) ? std::max(way, 0.0) : most);
    }
  }
  return sum / distances_.squaredNorm();
}

}  // namespace conddp
