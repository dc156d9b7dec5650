// Small problems whose iterations are counted and printed. They are made without problem files, so
// that few sources are needed.
#pragma once

#include <map>
#include <string>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A quadruped: two diagonal swings on the spot.
ShootingProblem counted_trot();
/// A 7-joint arm whose tool goes to a placement under torque limits.
ShootingProblem counted_reach();
/// A biped that lowers its centre of mass on two soles.
ShootingProblem counted_squat();
/// A cart-pole that swings up with a weak motor and has to stand upright at the end: a small
/// system.
ShootingProblem counted_swing();
/// A quadrotor on SE(3) that flies to a place: a step of several stages on a curved space.
ShootingProblem counted_flight();
/// The quadruped's swings with weak torques and hard friction pyramids.
ShootingProblem counted_grip();

/// All of them by name.
const std::map<std::string, ShootingProblem (*)()>& counted_problems();

}  // namespace conddp
