#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/terms/free_duration.hpp"
#include "problem_file/plant/plant.hpp"
#include "systems/initial_choice.hpp"

namespace conddp {

/// How a first knot without time chooses the initial state, and how long phases last.
struct InitialChoice {
  std::shared_ptr<const System> system;
  std::vector<double> state;                           ///< from which
  std::vector<int> coordinates;                        ///< tangent coordinates that it moves
  std::vector<double> lower, upper;                    ///< of the displacement, then of durations
  bool remembered = false;                             ///< all later nodes know what was chosen
  std::vector<std::optional<FreeDuration>> durations;  ///< by phase
  int first_controls = 0;  ///< where controls are linear, these at the start: the last choices
  /// Of a periodic motion whose knots remember the control before, that before the first one: the
  /// last choices.
  int previous_controls = 0;

  /// Numbers that all later nodes hand on.
  int carried() const { return remembered ? system->nu() - first_controls : 0; }
};

struct BuiltInitialChoice {
  bool valid = true;
  std::optional<InitialChoice> choice;  ///< nothing where the initial state is given
};

/// Built from the first phase; faults are reported. `previous`: states hold the previous control.
BuiltInitialChoice build_initial_choice(const ProblemSpec& spec, const Plant& plant,
                                        const std::vector<double>& state, bool previous,
                                        Diagnostics& out);

}  // namespace conddp
