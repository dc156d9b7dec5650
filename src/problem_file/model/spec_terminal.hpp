#pragma once

#include <optional>

#include "problem_file/model/spec_values.hpp"

namespace conddp {

/// A terminal cost, optionally with a terminal set, from the linear-quadratic regulator about an
/// equilibrium.
struct TerminalLqrSpec {
  Place place;
  /// The equilibrium: a configuration or "initial", or a state.
  std::optional<Name> name;
  StateSpec state;
  PlanarMotion moved;  ///< displacement of its base by a gait, in a closed loop
  double weight = 1;
  bool set = false;
  Place set_place;
};

}  // namespace conddp
