#pragma once

namespace conddp {

/// The merit φ = J + ν Σ‖gap‖₁ around an iterate. Closed gaps leave the cost alone.
struct MeritModel {
  double cost = 0;                   ///< J of the iterate
  double gap_norm = 0;               ///< Σ‖gap‖₁ of the iterate; of an EqualitySearch θ
  double penalty = 0;                ///< ν, so large that closing gaps is descent
  double slope = 0;                  ///< ∇J·d of the model's full step
  bool slope_within_bounds = false;  ///< that step meets no bound on its way
  double rounding = 0;               ///< size of J's rounding errors
  double value() const { return cost + penalty * gap_norm; }
  /// Derivative of φ along the step: gaps shrink by (1 − α).
  double merit_slope() const { return slope - penalty * gap_norm; }
  /// Whether the step lowers the merit at first, as far as rounding lets it be seen.
  bool descends() const { return merit_slope() < 0 || hidden(merit_slope()); }
  /// Whether rounding hides a change of that size.
  bool hidden(double change) const;
  /// Armijo's rule, that a trial reaches the share `armijo` of the decrease expected to first
  /// order. The first trial also passes where rounding hides both decreases.
  bool passes(double expected, double actual, double armijo, bool first) const;
};

}  // namespace conddp
