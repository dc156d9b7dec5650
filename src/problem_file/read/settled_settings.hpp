#pragma once

#include <vector>

#include "problem_file/read/read_problem.hpp"

namespace conddp {

/// Settings with formulas replaced by their values in the document: `=2*mass` becomes a number. If
/// a setting is invalid there, all settings are returned unchanged.
std::vector<Setting> settled_settings(const ProblemDocument& document,
                                      const std::vector<Setting>& settings);

}  // namespace conddp
