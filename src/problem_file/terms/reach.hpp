#pragma once

#include <vector>

#include "problem_file/terms/constraint_builder.hpp"

namespace conddp {

/// Warns of frame positions required by costs or equalities that no joint angles reach. Such
/// positions are farther from the first joint of the frame's chain than the total length of its
/// links. Chains with sliding or floating joints are exempt.
void warn_of_reach(const std::vector<BuiltCost>& costs,
                   const std::vector<BuiltConstraint>& constraints, const Plant& plant,
                   Diagnostics& out);

}  // namespace conddp
