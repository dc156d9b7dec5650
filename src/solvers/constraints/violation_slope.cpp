#include "solvers/constraints/violation_slope.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/problem/problem.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

/// Largest size of a control anywhere, at least 1.
double largest_control(const Trajectory& trajectory) {
  double largest = 1;
  for (int k = 0; k < trajectory.knots(); ++k)
    if (trajectory.u(k).size() > 0)
      largest = std::max(largest, trajectory.u(k).lpNorm<Eigen::Infinity>());
  return largest;
}

/// Distance that a control can move against a slope.
double way_down(const ControlBounds& bounds, int k, Eigen::Index i, double u, double slope) {
  return slope > 0 ? u - bounds.lower(k)[i] : bounds.upper(k)[i] - u;
}

}  // namespace

ViolationSlope::ViolationSlope(const ShootingProblem& problem, const ControlBounds& bounds)
    : problem_(problem),
      bounds_(bounds),
      distances_(Eigen::VectorXd::Zero(problem.constraint_rows())),
      lagrangian_(problem),
      linearization_(problem),
      no_feedback_(problem),
      descent_(problem),
      closed_(problem),
      rollout_(problem, bounds),
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
  // The cost's own gradient is subtracted, however small: at a penalty's minimum, it cancels the
  // requested one.
  const Eigen::VectorXd of_cost = gradient(Eigen::VectorXd::Zero(distances_.size()));
  // The multiplier is so large that its effect on the cost's gradient keeps its digits.
  const Eigen::VectorXd with_distances = gradient(distances_ / tuning::kExact);
  const Eigen::VectorXd slope = (with_distances - of_cost) * tuning::kExact;
  return std::max(share(slope, trajectory), free_share(slope, trajectory));
}

double ViolationSlope::share(const Eigen::VectorXd& gradient, const Trajectory& trajectory) const {
  const double most = largest_control(trajectory);
  double sum = 0;
  for (int k = 0; k < bounds_.knots(); ++k)
    for (Eigen::Index i = 0; i < trajectory.u(k).size(); ++i) {
      const double slope = gradient[bounds_.offset(k) + i];
      const double way = way_down(bounds_, k, i, trajectory.u(k)[i], slope);
      sum += std::abs(slope) * (std::isfinite(way) ? std::max(way, 0.0) : most);
    }
  return sum / distances_.squaredNorm();
}

/// Part of ‖d‖² that the best step removes along the steepest descent of the controls without a
/// bound ahead. `gradient` is that of ½‖d‖², and the linearization belongs to it.
double ViolationSlope::free_share(const Eigen::VectorXd& gradient, const Trajectory& trajectory) {
  double squared = 0;
  for (int k = 0; k < bounds_.knots(); ++k)
    for (Eigen::Index i = 0; i < trajectory.u(k).size(); ++i) {
      const double slope = gradient[bounds_.offset(k) + i];
      const bool free = !std::isfinite(way_down(bounds_, k, i, trajectory.u(k)[i], slope));
      descent_.k[k][i] = free ? -slope : 0;
      squared += free ? slope * slope : 0;
    }
  if (squared == 0) return 0;
  for (Eigen::VectorXd& k : descent_.k) k /= std::sqrt(squared);
  rollout_.run(linearization_, trajectory, closed_, descent_, false);
  const double change = squared_change();
  return change > 0 ? squared / (change * distances_.squaredNorm()) : 0;
}

/// ‖J p‖² of the step p that is rolled out; 0 if it is only rounding.
double ViolationSlope::squared_change() const {
  double sum = 0, far = 0;
  for (const NodeConstraint& c : problem_.constraints()) {
    if (c.is_soft()) continue;
    const auto distance = distances_.segment(c.row, c.term->rows);
    if ((distance.array() == 0).all()) continue;
    const auto C = linearization_.knots[c.node].C.middleRows(
        c.row - problem_.constraint_offset(c.node), c.term->rows);
    const Eigen::VectorXd y = C * rollout_.z(c.node);
    sum += c.term->is_cone() ? y.squaredNorm()
                             : (distance.array() != 0).select(y, 0).matrix().squaredNorm();
    far =
        std::max(far, C.lpNorm<Eigen::Infinity>() * rollout_.dx(c.node).lpNorm<Eigen::Infinity>());
  }
  return sum > tuning::kRounding * tuning::kRounding * far * far ? sum : 0;
}

}  // namespace conddp
