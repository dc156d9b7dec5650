#pragma once

#include <vector>

#include "systems/system.hpp"

namespace conddp {

/// The name of the clock, a state (s) of systems that depend on the time, which no other column
/// has, and beside it of its velocity (s/s) in second-order systems.
inline constexpr const char* kClock = "t";
inline constexpr const char* kClockRate = "t_rate";

/// Where the numbers of a state are that are not the clock's.
std::vector<int> states_without_clock(const System& system);
/// The tangent coordinates of the clock and of its velocity; none of other systems.
std::vector<int> clock_coordinates(const System& system);

}  // namespace conddp
