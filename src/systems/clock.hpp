#pragma once

namespace conddp {

/// Reserved name of the clock, a state (s) of systems that depend on time. In second-order systems
/// its rate (s/s) is a state too.
inline constexpr const char* kClock = "t";
inline constexpr const char* kClockRate = "t_rate";

}  // namespace conddp
