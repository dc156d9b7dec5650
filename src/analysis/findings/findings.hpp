#pragma once

#include <vector>

#include "analysis/findings/finding.hpp"
#include "ocp/problem/node_values.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Finds everything remarkable along a trajectory with these values, sorted by kind, the worst of
/// each kind first. Evaluates in scalar code; empty if the trajectory is not finite. `gains`:
/// feedback along the trajectory.
std::vector<Finding> find_in_motion(const ShootingProblem& problem, const Trajectory& trajectory,
                                    const std::vector<Eigen::MatrixXd>& gains,
                                    const NodeValues& values, const FindingNames& names);

/// Findings of kind between_knots whose motion passes through something it should go around.
std::vector<Finding> find_jumps(const ShootingProblem& problem, const Trajectory& trajectory);

}  // namespace conddp
