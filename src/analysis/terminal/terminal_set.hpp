#pragma once

#include <string>
#include <vector>

#include "analysis/terminal/terminal_ingredients.hpp"

namespace conddp {

/// How large the ellipsoid (x ⊖ x̄)ᵀP(x ⊖ x̄) ≤ level may be before a bound or a constraint of the
/// knot, linearized at the equilibrium under the regulator, is met.
struct TerminalBound {
  std::string name;
  double distance = 0;  ///< at the equilibrium, negative where it is violated
  double level = 0;
};

/// The largest ellipsoid within all of them.
struct TerminalSet {
  double level = 0;  ///< infinite where nothing bounds it
  std::vector<TerminalBound>
      bounds;  ///< the narrowest first; those that nothing moves are left out
};

/// Bounds on the control and hard constraints of the knot. Cones, and norms from above, are met
/// where the parts of their values that the ellipsoid moves could meet them in the worst direction,
/// which is within the cone.
TerminalSet largest_terminal_set(const TerminalIngredients& ingredients);

}  // namespace conddp
