#pragma once

#include <vector>

#include "analysis/findings/finding.hpp"
#include "ocp/problem/node_values.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Everything that stands out along a trajectory with these values, kind after kind, of each kind
/// the worst first. Evaluated by scalar code; empty where the trajectory is not finite. `gains`: of
/// feedback along it.
std::vector<Finding> find_in_motion(const ShootingProblem& problem, const Trajectory& trajectory,
                                    const std::vector<Eigen::MatrixXd>& gains,
                                    const NodeValues& values, const FindingNames& names);

/// Those of kind between_knots where the motion leads through what it should go around.
std::vector<Finding> find_jumps(const ShootingProblem& problem, const Trajectory& trajectory);

}  // namespace conddp
