#pragma once

#include "ocp/problem/problem.hpp"

namespace conddp {

/// The problem of the least violation: half the squared distances of all hard constraints from
/// their sets are what is minimised, in place of all costs and soft constraints. Dynamics, bounds
/// on controls and the shape of trajectories are the same. Complementary pairs are left out.
ShootingProblem violation_problem(const ShootingProblem& problem);

}  // namespace conddp
