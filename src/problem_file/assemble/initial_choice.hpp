#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "ocp/terms/constraint.hpp"
#include "problem_file/plant/plant.hpp"
#include "systems/initial_choice.hpp"

namespace conddp {

/// First, instantaneous knot that chooses the initial state and the durations of phases.
struct InitialChoice {
  std::shared_ptr<const System> system;
  std::vector<double> state;                           ///< initial state before the displacement
  std::vector<int> coordinates;                        ///< tangent coordinates that it displaces
  std::vector<double> lower, upper;                    ///< of the displacement, then of durations
  bool remembered = false;                             ///< true if all later nodes store the choice
  std::vector<std::optional<FreeDuration>> durations;  ///< by phase
  /// Number of linear controls at the start, unless they are given: the last choices.
  int first_controls = 0;
  /// For a periodic motion whose knots store the previous control: number of entries of the control
  /// before the first knot, which are the last choices.
  int previous_controls = 0;

  /// Number of choices that all later nodes pass on.
  int carried() const { return remembered ? system->nu() - first_controls : 0; }
};

struct BuiltInitialChoice {
  bool valid = true;
  std::optional<InitialChoice> choice;  ///< empty if the initial state is given
};

/// Builds the choice from the first phase and reports errors. `previous`: states hold the previous
/// control.
BuiltInitialChoice build_initial_choice(const ProblemSpec& spec, const Plant& plant,
                                        const std::vector<double>& state, bool previous,
                                        Diagnostics& out);

}  // namespace conddp
