#pragma once

#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// Where the numbers of a state are that the equations of a system are about: neither those of its
/// clock nor parameters nor states at rest, which it lacks.
std::vector<int> own_states(const System& system);
/// The tangent coordinates of all other numbers: of the clock, parameters, their velocities and
/// states at rest.
std::vector<int> other_coordinates(const System& system);

}  // namespace conddp
