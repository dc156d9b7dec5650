#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "analysis/terminal/terminal_set.hpp"

namespace conddp {

/// One of the conditions of Mayne, Rawlings, Rao and Scokaert (2000), by which a terminal set and
/// cost make model-predictive control stable, on samples of the ellipsoid and the nonlinear map.
struct TerminalCondition {
  std::string name;     ///< "A1" to "A4"
  std::string meaning;  ///< one line
  bool holds = false;
  double figure = 0;  ///< A1, A2: largest violation; A3: largest ratio of the values after and
                      ///< before the step; A4: least decrease of the terminal cost by the stage
                      ///< cost, 1 where they are equal
  double level = 0;   ///< the largest of the tested levels at which it holds, 0 if there is none
};

/// Where a larger weight makes A4 hold.
struct TerminalDecrease {
  double level = 0;   ///< the largest of the tested levels, 0 if there is none
  double factor = 0;  ///< of the weight, by which A4 holds there; at least 1
};

struct TerminalConditions {
  double level = 0;  ///< of the ellipsoid that was sampled
  int samples = 0;   ///< none where it is the equilibrium alone, or P is zero
  std::vector<TerminalCondition>
      conditions;  ///< A1 and A2 where the ellipsoid is the equilibrium alone; none where P is zero
  TerminalDecrease decrease;

  bool hold() const;
};

struct ConditionOptions {
  double weight = 1;  ///< of the terminal cost, by which P is multiplied
  double level = 0;   ///< of the ellipsoid; infinite: such that no state moves by more than 0.1
  double tolerance = 1e-6;  ///< of constraints and bounds
  int samples = 1000;
  std::uint64_t seed = 1;
};

/// Checks the conditions at the level and at levels down to 4⁻¹⁰ of it. The stage cost of A4 is
/// that of the knot without its value and its slope at the equilibrium, which is the stage cost
/// itself where that is least at the equilibrium. Directions that cost nothing are not sampled.
TerminalConditions check_terminal_conditions(const TerminalIngredients& ingredients,
                                             const ConditionOptions& options);

}  // namespace conddp
