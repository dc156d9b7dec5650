#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Equations that give no finite number in a state, and what would be finite nearby.
struct SingularRate {
  std::string row;    ///< whose rate, or next value, is not finite
  std::string state;  ///< the first state that makes all finite when it moves; empty: none does
  double value = 0;   ///< of that state
  double nearby = 0;  ///< a value of it at which the equations are finite, for a step of the knot
};

/// Of the equations at a knot of a trajectory; empty where they are finite.
std::optional<SingularRate> singular_rate(const ShootingProblem& problem,
                                          const Trajectory& trajectory, int knot);

}  // namespace conddp
