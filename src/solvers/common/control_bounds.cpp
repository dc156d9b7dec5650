#include "solvers/common/control_bounds.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "ocp/problem/problem.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

/// u = ū + (bound − ū) may miss the bound by a rounding error of its operands.
bool meets(double u, double bound) {
  return std::isfinite(bound) &&
         std::abs(u - bound) <= tuning::kUlps * std::max(std::abs(bound), 1.0);
}

}  // namespace

ControlBounds::ControlBounds(const ShootingProblem& problem) : offset_{0} {
  for (int k = 0; k < problem.knots(); ++k) offset_.push_back(offset_.back() + problem.nu(k));
  lower_.resize(size());
  upper_.resize(size());
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotModel& model = *problem.knot(k).model;
    for (int i = 0; i < problem.nu(k); ++i) {
      lower_[offset_[k] + i] = model.control_lower()[i];
      upper_[offset_[k] + i] = model.control_upper()[i];
    }
  }
}

int ControlBounds::clamp(Trajectory& trajectory) const {
  int changed = 0;
  for (int k = 0; k < knots(); ++k) {
    auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i) {
      const double inside = std::max(lower(k)[i], std::min(u[i], upper(k)[i]));
      changed += inside != u[i];
      u[i] = inside;
    }
  }
  return changed;
}

void ControlBounds::snap_rounded(Trajectory& trajectory) const {
  for (int k = 0; k < knots(); ++k)
    for (int i = 0; i < trajectory.u(k).size(); ++i)
      for (const double bound : {lower(k)[i], upper(k)[i]})
        if (std::isfinite(bound) && std::abs(trajectory.u(k)[i] - bound) <=
                                        tuning::kRounding * std::max(1.0, std::abs(bound)))
          trajectory.u(k)[i] = bound;
}

Extremum ControlBounds::violation(const Trajectory& trajectory) const {
  Extremum worst;
  for (int k = 0; k < knots(); ++k) {
    const auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i) {
      const double outside = std::max(lower(k)[i] - u[i], u[i] - upper(k)[i]);
      if (outside > worst.value) worst = {outside, k};
    }
  }
  return worst;
}

bool ControlBounds::at_lower(int k, int i, double u) const {
  return u <= lower(k)[i] || meets(u, lower(k)[i]);
}

bool ControlBounds::at_upper(int k, int i, double u) const {
  return u >= upper(k)[i] || meets(u, upper(k)[i]);
}

Extremum ControlBounds::projected_norm(const Eigen::VectorXd& gradient,
                                       const Trajectory& trajectory) const {
  Extremum worst;
  for (int k = 0; k < knots(); ++k) {
    const auto u = trajectory.u(k);
    for (int i = 0; i < u.size(); ++i) {
      const double g = gradient[offset_[k] + i];
      if (pushed_out(k, i, u[i], g)) continue;
      worst.meet(std::abs(g), k);
    }
  }
  return worst;
}

Extremum largest_violation(const ShootingProblem& problem, const ControlBounds& bounds,
                           const Trajectory& trajectory, const Eigen::VectorXd& constraint) {
  Extremum worst = bounds.violation(trajectory);
  for (const NodeConstraint& c : problem.constraints())
    worst.meet(violation(c, constraint.data() + c.row), c.node);
  return worst;
}

}  // namespace conddp
