#pragma once

#include <optional>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A step of an explicit rule on which a motion grows that decays in time: it is too long.
struct LongStep {
  int knot = 0;
  double rate = 0;     ///< at which the motion decays there, 1/s
  double growth = 0;   ///< what the step multiplies the motion by instead
  double longest = 0;  ///< s: steps up to about this are stable
};

/// The step of a trajectory on which such a motion grows most, and at least to the double; nothing
/// where there is none. Other steps than those of Runge-Kutta rules are not judged, nor those at
/// which derivatives are not finite.
std::optional<LongStep> long_step(const ShootingProblem& problem, const Trajectory& trajectory);

}  // namespace conddp
