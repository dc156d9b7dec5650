#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// The joint with the largest lack of torque (or force) for holding a robot still.
struct MissingTorque {
  std::string joint;
  std::string unit;     ///< unit of the torque: Nm or N
  double needed = 0;    ///< magnitude that would hold it, if the other joints are strong enough
  double limit = 0;     ///< largest torque of its control in that direction, 0 without a control
  bool driven = false;  ///< true if it has a control
};

/// Tests whether the initial state lacks static equilibrium because torques are too weak. This
/// applies to a robot at rest, on its contacts or with a control at every joint. It lacks
/// equilibrium if it moves off with all controls within their bounds, but would not with an
/// unbounded control at every joint. Returns nullopt if the robot can be held, if it moves, or if
/// no torque would hold it, as in free fall or when tipping over.
std::optional<MissingTorque> missing_torque(const ShootingProblem& problem);

}  // namespace conddp
