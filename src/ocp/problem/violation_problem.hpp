#pragma once

#include "ocp/problem/problem.hpp"

namespace conddp {

/// The problem of least violation: minimizes half the squared distances of all hard constraints
/// from their sets, in place of all costs and soft constraints. Dynamics, control bounds and
/// trajectory shape are the same. Complementarity constraints are omitted.
ShootingProblem violation_problem(const ShootingProblem& problem);

}  // namespace conddp
