#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Equations without a finite value in a state, and a nearby state with finite values.
struct SingularRate {
  std::string row;    ///< the row whose rate, or next value, is not finite
  std::string state;  ///< first state whose move makes all rows finite; empty if none does
  double value = 0;   ///< value of that state
  double nearby = 0;  ///< a value of it with finite equations, for a step of the knot
};

/// Examines the equations at a knot of a trajectory; nullopt if they are finite.
std::optional<SingularRate> singular_rate(const ShootingProblem& problem,
                                          const Trajectory& trajectory, int knot);

}  // namespace conddp
