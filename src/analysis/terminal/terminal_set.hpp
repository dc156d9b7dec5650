#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/terminal/terminal_ingredients.hpp"

namespace conddp {

/// Largest level of the ellipsoid (x ⊖ x̄)ᵀP(x ⊖ x̄) ≤ level within one bound or constraint of the
/// knot, linearized at the equilibrium under the regulator.
struct TerminalBound {
  std::string name;
  double distance = 0;  ///< distance at the equilibrium, negative if violated
  double level = 0;
};

/// Largest ellipsoid within all bounds.
struct TerminalSet {
  double level = 0;  ///< infinite if nothing bounds it
  /// The narrowest first; bounds that nothing moves are left out.
  std::vector<TerminalBound> bounds;
};

/// Considers control bounds and hard constraints of the knot. For cones and upper bounds on norms,
/// the moving parts of their values count in the worst direction, which stays within the cone.
TerminalSet largest_terminal_set(const TerminalIngredients& ingredients);

/// One of the conditions of Mayne, Rawlings, Rao and Scokaert (2000) for the stability of model
/// predictive control with a terminal set and cost. It is checked on samples of the ellipsoid with
/// the nonlinear map.
struct TerminalCondition {
  std::string name;     ///< "A1" to "A4"
  std::string meaning;  ///< one line
  bool holds = false;
  /// A1, A2: largest violation. A3: largest ratio of the values after and before the step. A4:
  /// least decrease of the terminal cost divided by the stage cost, 1 if they are equal.
  double figure = 0;
  double level = 0;  ///< largest tested level that satisfies it, or 0
};

/// A larger weight that makes A4 hold.
struct TerminalDecrease {
  double level = 0;   ///< largest tested level, or 0
  double factor = 0;  ///< factor on the weight for A4 to hold there; at least 1
};

struct TerminalConditions {
  double level = 0;  ///< level of the sampled ellipsoid
  int samples = 0;   ///< 0 if the ellipsoid is the equilibrium alone, or if P is zero
  /// A1 and A2 if the ellipsoid is the equilibrium alone; empty if P is zero.
  std::vector<TerminalCondition> conditions;
  TerminalDecrease decrease;

  bool hold() const;
};

struct ConditionOptions {
  double weight = 1;        ///< factor on the terminal cost and hence on P
  double level = 0;         ///< of the ellipsoid; infinite: no state moves by more than 0.1
  double tolerance = 1e-6;  ///< of constraints and bounds
  int samples = 1000;
  std::uint64_t seed = 1;
};

/// Checks the conditions at the level and at levels down to 4⁻¹⁰ of it. The stage cost of A4 is
/// that of the knot minus its value and slope at the equilibrium. It is the stage cost itself if
/// that is least at the equilibrium. Directions without cost are not sampled.
TerminalConditions check_terminal_conditions(const TerminalIngredients& ingredients,
                                             const ConditionOptions& options);

}  // namespace conddp
