#pragma once

namespace conddp {

/// The name of the clock, a state (s) of systems that depend on the time, which no other column
/// has, and beside it of its velocity (s/s) in second-order systems.
inline constexpr const char* kClock = "t";
inline constexpr const char* kClockRate = "t_rate";

}  // namespace conddp
