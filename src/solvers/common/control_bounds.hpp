#pragma once

#include <cmath>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A residual's size and the knot at which it is attained (−1 where it is zero everywhere).
struct Extremum {
  double value = 0;
  int knot = -1;

  /// Not-a-number counts as the largest.
  void meet(double candidate, int k) {
    if (!std::isnan(value) && !(candidate <= value)) *this = {candidate, k};
  }
};

/// The control bounds of all knots, one after the other as Trajectory stores controls.
class ControlBounds {
 public:
  explicit ControlBounds(const ShootingProblem& problem);

  int knots() const { return static_cast<int>(offset_.size()) - 1; }
  int size() const { return offset_.back(); }
  /// Where the entries of knot k start.
  int offset(int k) const { return offset_[k]; }
  auto lower(int k) const { return lower_.segment(offset_[k], offset_[k + 1] - offset_[k]); }
  auto upper(int k) const { return upper_.segment(offset_[k], offset_[k + 1] - offset_[k]); }

  /// Projects the controls on their bounds; returns how many entries changed.
  int clamp(Trajectory& trajectory) const;
  /// Largest distance of a control from its bounds.
  Extremum violation(const Trajectory& trajectory) const;
  /// Whether a control stands at its lower bound, its upper one, or either, to rounding.
  bool at_lower(int k, int i, double u) const;
  bool at_upper(int k, int i, double u) const;
  bool at_bound(int k, int i, double u) const { return at_lower(k, i, u) || at_upper(k, i, u); }
  /// Whether a control stands at a bound (to rounding) that a descent along its entry of a gradient
  /// would cross.
  bool pushed_out(int k, int i, double u, double gradient) const {
    return (gradient > 0 && at_lower(k, i, u)) || (gradient < 0 && at_upper(k, i, u));
  }
  /// ‖gradient‖∞ without the entries that push their control out: there the bound's multiplier
  /// balances the gradient.
  Extremum projected_norm(const Eigen::VectorXd& gradient, const Trajectory& trajectory) const;

 private:
  std::vector<int> offset_;
  Eigen::VectorXd lower_, upper_;
};

/// Largest violation of control bounds and constraints, from the values of all constraint rows; not
/// finite where a value is not.
Extremum largest_violation(const ShootingProblem& problem, const ControlBounds& bounds,
                           const Trajectory& trajectory, const Eigen::VectorXd& constraint);

}  // namespace conddp
