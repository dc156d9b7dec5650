#pragma once

#include <optional>

#include "problem_file/spec/spec_values.hpp"

namespace conddp {

/// A terminal cost, and if asked for a terminal set, from the linear-quadratic regulator about an
/// equilibrium.
struct TerminalLqrSpec {
  Place place;
  /// The equilibrium: a configuration or "initial", or a state.
  std::optional<Name> name;
  StateSpec state;
  PlanarMotion moved;  ///< of its base, by the way of a gait with which a closed loop moves it
  double weight = 1;
  bool set = false;
  Place set_place;
};

}  // namespace conddp
