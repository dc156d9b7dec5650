#pragma once

#include <vector>

#include "analysis/findings/finding.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Reports steps that are too long for their rule (long_step()), and a grid that does not resolve
/// the motion (coarse_grid()). The latter lists the errors of other rules and shorter steps at this
/// motion.
void find_in_grid(const ShootingProblem& problem, const Trajectory& trajectory,
                  const std::vector<Eigen::MatrixXd>& gains, std::vector<Finding>& list);

}  // namespace conddp
