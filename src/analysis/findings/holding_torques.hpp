#pragma once

#include <optional>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// The joint that most lacks the torque (or force) to hold a robot still.
struct MissingTorque {
  std::string joint;
  std::string unit;     ///< of the torque: Nm or N
  double needed = 0;    ///< what would hold it, with the other joints as strong as they need to be,
                        ///< without its sign
  double limit = 0;     ///< what its control gives in that direction at most, 0 without a control
  bool driven = false;  ///< whether it has a control
};

/// Whether the initial state lacks static equilibrium for want of torque: at rest, on its contacts
/// or with a control at every joint, a robot moves off with all controls within their bounds, and
/// would not if every joint had a control without bounds. None where it can be held, where it
/// moves, and where no torque would hold it, as what falls freely or tips over.
std::optional<MissingTorque> missing_torque(const ShootingProblem& problem);

}  // namespace conddp
