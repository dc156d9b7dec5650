#pragma once

#include <vector>

#include "problem_file/terms/constraint_builder.hpp"

namespace conddp {

/// Warns of frame positions that costs or equalities require and inverse kinematics does not find
/// within the joints' limits. Frames behind a floating joint, and robots with free parameters, are
/// exempt.
void warn_of_reach(const std::vector<BuiltCost>& costs,
                   const std::vector<BuiltConstraint>& constraints, const Plant& plant,
                   Diagnostics& out);

}  // namespace conddp
