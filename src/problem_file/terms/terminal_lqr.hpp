#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "analysis/terminal/terminal_set.hpp"
#include "problem_file/motion/state_builder.hpp"

namespace conddp {

/// The name of the cost, and of the constraint, that `terminal: {lqr: ...}` adds to the last node.
inline constexpr const char* kTerminalLqrName = "lqr";

/// What `terminal: {lqr: ...}` stands for.
struct TerminalLqr {
  TerminalIngredients ingredients;
  TerminalSet set;
  double weight = 1;
  bool constrained = false;  ///< whether the last state has to lie in the set
};

/// What the ingredients are computed from.
struct TerminalLqrContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const StateBuilder& states;
  const std::vector<Phase>& phases;
  bool previous_control;  ///< states end with the previous control
  bool carried_choices;   ///< states hold what was chosen at the start
};

/// The equilibrium that the file names.
std::optional<std::vector<double>> equilibrium_of(const TerminalLqrSpec& lqr,
                                                  const StateBuilder& states);

/// From the last knot that takes time. A state that is no equilibrium there, a knot without a
/// regulator, and names that are taken are reported; so is an ellipsoid of which nothing is left,
/// or that nothing bounds, where it is to be a constraint.
std::shared_ptr<const TerminalLqr> build_terminal_lqr(const TerminalLqrContext& context,
                                                      Diagnostics& out);

/// Adds its cost, and its constraint if there is one, to the model of the last node and the numbers
/// behind the node's parameters.
void add_terminal_lqr(const TerminalLqr& lqr, KnotModel& model, std::vector<double>& parameters);

}  // namespace conddp
