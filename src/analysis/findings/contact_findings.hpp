#pragma once

#include "analysis/findings/finding.hpp"
#include "ocp/problem/node_values.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// What scheduled contacts do along a finite trajectory with these values: how far they move while
/// they are held, what friction they need, where they pull, and which depend on each other.
void find_in_contacts(const ShootingProblem& problem, const Trajectory& trajectory,
                      const NodeValues& values, const FindingNames& names,
                      std::vector<Finding>& list);

}  // namespace conddp
