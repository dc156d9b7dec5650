#pragma once

#include <string_view>

#include "analysis/findings/finding.hpp"
#include "ocp/problem/node_values.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Ends the velocity of contacts at once, as neither their damping nor a rule of steps can.
inline constexpr std::string_view kImpulseRemedy =
    "an impulse ('gait: {impulses: true}', or a phase '- {impulse: NAME}')";

/// Adds findings on scheduled contacts along a finite trajectory with these values: drift of held
/// contacts, friction demand, pulling forces, and dependent contacts.
void find_in_contacts(const ShootingProblem& problem, const Trajectory& trajectory,
                      const NodeValues& values, const FindingNames& names,
                      std::vector<Finding>& list);

}  // namespace conddp
