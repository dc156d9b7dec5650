#pragma once

#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// Indices of the state's numbers that the equations of a system are about. Excludes the clock,
/// parameters and states at rest, which this system lacks.
std::vector<int> own_states(const System& system);
/// Tangent coordinates of all other numbers: the clock, parameters, their velocities and states at
/// rest.
std::vector<int> other_coordinates(const System& system);

}  // namespace conddp
