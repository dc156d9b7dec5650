// Small problems for counting and printing iterations, built without problem files to link few
// sources.
#pragma once

#include <map>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Quadruped: two diagonal swings in place.
ShootingProblem counted_trot();
/// 7-joint arm that reaches a tool placement under torque limits.
ShootingProblem counted_reach();
/// Biped that lowers its center of mass on two soles.
ShootingProblem counted_squat();
/// Cart-pole swing-up with a weak motor and a terminal constraint: a small system.
ShootingProblem counted_swing();
/// Quadrotor flight on SE(3): multi-stage steps on a curved space.
ShootingProblem counted_flight();
/// Quadruped swings with weak torques and hard friction pyramids.
ShootingProblem counted_grip();

/// All counted problems by name.
const std::map<std::string, ShootingProblem (*)()>& counted_problems();

}  // namespace conddp
