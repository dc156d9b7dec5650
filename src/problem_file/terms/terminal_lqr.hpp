#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "analysis/terminal/terminal_set.hpp"
#include "problem_file/motion/state_builder.hpp"

namespace conddp {

/// The name of the cost and of the constraint that `terminal: {lqr: ...}` adds to the last node.
inline constexpr const char* kTerminalLqrName = "lqr";

/// Terminal cost and set for `terminal: {lqr: ...}`.
struct TerminalLqr {
  TerminalIngredients ingredients;
  TerminalSet set;
  double weight = 1;
  bool constrained = false;  ///< the last state must lie in the set
};

/// Input for computing the ingredients.
struct TerminalLqrContext {
  const ProblemSpec& spec;
  const Plant& plant;
  const StateBuilder& states;
  const std::vector<Phase>& phases;
  std::vector<Column> tail;           ///< columns behind the system's state
  std::vector<double> tail_at_start;  ///< their values as the file writes them
};

/// The equilibrium that the file names.
std::optional<std::vector<double>> equilibrium_of(const TerminalLqrSpec& lqr,
                                                  const StateBuilder& states);

/// Computes the ingredients from the last knot that takes time. Reports a state that is not an
/// equilibrium there, a knot without a regulator, and names that are already taken. If the set is
/// to be a constraint, also reports an empty or unbounded ellipsoid.
std::shared_ptr<const TerminalLqr> build_terminal_lqr(const TerminalLqrContext& context,
                                                      Diagnostics& out);

/// Adds its cost, and its constraint, if any, to the model of the last node. Appends their numbers
/// to the node's parameters.
void add_terminal_lqr(const TerminalLqr& lqr, KnotModel& model, std::vector<double>& parameters);

}  // namespace conddp
