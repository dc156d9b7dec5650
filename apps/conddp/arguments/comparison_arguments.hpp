#pragma once

#include <string>
#include <vector>

#include "analysis/comparison/solution_comparison.hpp"
#include "arguments/command.hpp"

namespace conddp {

/// --tolerance NAME=NUMBER; comparison_tolerances() replaces tolerances by these values.
Argument comparison_tolerance_argument(std::vector<std::string>& values);
ComparisonTolerances comparison_tolerances(const std::vector<std::string>& values,
                                           ComparisonTolerances tolerances = {});

/// One difference as a line of text.
std::string difference_text(const Difference& difference);

}  // namespace conddp
