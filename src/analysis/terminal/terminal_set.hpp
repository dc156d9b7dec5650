#pragma once

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

}  // namespace conddp
