#pragma once

#include <optional>
#include <vector>

#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Values for the tangent coordinates of a problem's states, resolved by the names of its system.
/// Missing values and augmented states are 0. Reports invalid components.
std::vector<double> tangent_numbers(const std::optional<ComponentsSpec>& components,
                                    const BuiltProblem& built, Diagnostics& out);

}  // namespace conddp
