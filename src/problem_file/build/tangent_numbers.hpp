#pragma once

#include <optional>
#include <vector>

#include "problem_file/build/build.hpp"

namespace conddp {

/// Numbers for the tangent coordinates of a problem's states, by the names of its system (nothing:
/// 0); 0 for augmented states. What is wrong with them is reported.
std::vector<double> tangent_numbers(const std::optional<ComponentsSpec>& components,
                                    const BuiltProblem& built, Diagnostics& out);

}  // namespace conddp
