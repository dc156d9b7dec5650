#pragma once

#include <string>
#include <vector>

#include <CLI/CLI.hpp>

#include "analysis/comparison/solution_comparison.hpp"

namespace conddp {

/// Adds --tolerance NAME=NUMBER; comparison_tolerances() puts its values in the place of others.
void add_comparison_tolerances(CLI::App& command, std::vector<std::string>& values);
ComparisonTolerances comparison_tolerances(const std::vector<std::string>& values,
                                           ComparisonTolerances tolerances = {});

/// One difference as a line of text.
std::string difference_text(const Difference& difference);

}  // namespace conddp
