// Three small problems whose iterations are counted and printed. They are made without problem
// files, so that few sources are needed.
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

/// All of them by name.
const std::map<std::string, ShootingProblem (*)()>& counted_problems();

}  // namespace conddp
