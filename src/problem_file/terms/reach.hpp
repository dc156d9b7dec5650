#pragma once

#include <vector>

#include "problem_file/terms/constraint_builder.hpp"

namespace conddp {

/// Warns of positions of frames that costs or equalities ask for and no angles of the joints reach:
/// farther from the first joint of the frame's chain than all links behind it are long together.
/// Chains that slide or float have no such length.
void warn_of_reach(const std::vector<BuiltCost>& costs,
                   const std::vector<BuiltConstraint>& constraints, const Plant& plant,
                   Diagnostics& out);

}  // namespace conddp
