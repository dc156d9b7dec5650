#pragma once

namespace conddp {

/// Share of the first-order decrease of the merit that a step has to reach, the usual one (Nocedal,
/// Wright 2006, section 3.1).
inline constexpr double kArmijo = 1e-4;

/// The merit φ = J + ν Σ‖gap‖₁ around an iterate. With closed gaps, only the cost remains.
struct MeritModel {
  double cost = 0;                   ///< J of the iterate
  double gap_norm = 0;               ///< Σ‖gap‖₁ of the iterate; θ in an EqualitySearch
  double penalty = 0;                ///< ν, large enough to make closing gaps a descent
  double slope = 0;                  ///< ∇J·d of the full model step
  bool slope_within_bounds = false;  ///< that step meets no bound
  double rounding = 0;               ///< size of J's rounding errors
  double value() const { return cost + penalty * gap_norm; }
  /// Derivative of φ along the step: gaps shrink by (1 − α).
  double merit_slope() const { return slope - penalty * gap_norm; }
  /// True if the step initially lowers the merit, as far as rounding shows.
  bool descends() const { return merit_slope() < 0 || hidden(merit_slope()); }
  /// True if rounding hides a change of this size.
  bool hidden(double change) const;
  /// Armijo's rule: a trial reaches kArmijo of the expected first-order decrease. The first trial
  /// also passes if rounding hides both decreases.
  bool passes(double expected, double actual, bool first) const;
};

}  // namespace conddp
