#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Largest value of a residual, and its knot; −1 if the residual is zero everywhere.
struct Extremum {
  double value = 0;
  int knot = -1;

  /// Treats NaN as the largest value.
  void meet(double candidate, int k) {
    if (!std::isnan(value) && !(candidate <= value)) *this = {candidate, k};
  }
};

/// Control bounds of all knots, in the order of Trajectory's controls.
class ControlBounds {
 public:
  explicit ControlBounds(const ShootingProblem& problem);

  int knots() const { return static_cast<int>(offset_.size()) - 1; }
  int size() const { return offset_.back(); }
  /// First entry of knot k.
  int offset(int k) const { return offset_[k]; }
  auto lower(int k) const { return lower_.segment(offset_[k], offset_[k + 1] - offset_[k]); }
  auto upper(int k) const { return upper_.segment(offset_[k], offset_[k + 1] - offset_[k]); }

  /// Projects the controls onto their bounds; returns the number of changed entries.
  int clamp(Trajectory& trajectory) const;
  /// Puts controls on bounds that they miss by rounding.
  void snap_rounded(Trajectory& trajectory) const;
  /// Largest distance of a control from its bounds.
  Extremum violation(const Trajectory& trajectory) const;
  /// True if a control is at its lower bound, its upper bound, or either, up to rounding.
  bool at_lower(int k, int i, double u) const;
  bool at_upper(int k, int i, double u) const;
  bool at_bound(int k, int i, double u) const { return at_lower(k, i, u) || at_upper(k, i, u); }
  /// True if a control is at a bound (up to rounding) that descent along its gradient entry would
  /// cross.
  bool pushed_out(int k, int i, double u, double gradient) const {
    return (gradient > 0 && at_lower(k, i, u)) || (gradient < 0 && at_upper(k, i, u));
  }
  /// ‖gradient‖∞ without the entries that push their control outward: there the bound's multiplier
  /// balances the gradient.
  Extremum projected_norm(const Eigen::VectorXd& gradient, const Trajectory& trajectory) const;

 private:
  std::vector<int> offset_;
  Eigen::VectorXd lower_, upper_;
};

/// Largest violation of control bounds and constraints, from the values of all constraint rows. Not
/// finite if a value is not finite.
Extremum largest_violation(const ShootingProblem& problem, const ControlBounds& bounds,
                           const Trajectory& trajectory, const Eigen::VectorXd& constraint);

}  // namespace conddp
