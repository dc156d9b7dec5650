#pragma once

#include "analysis/findings/finding.hpp"
#include "ocp/problem/node_values.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Adds findings on scheduled contacts along a finite trajectory with these values: drift of held
/// contacts, friction demand, pulling forces, and dependent contacts.
void find_in_contacts(const ShootingProblem& problem, const Trajectory& trajectory,
                      const NodeValues& values, const FindingNames& names,
                      std::vector<Finding>& list);

}  // namespace conddp
