#pragma once

#include <vector>

#include "problem_file/read/read_problem.hpp"

namespace conddp {

/// Settings of a document as it is read with them: `=2*mass` is the number that it gives. Where
/// this cannot be said, because one of them has no meaning there, all stay as they are.
std::vector<Setting> settled_settings(const ProblemDocument& document,
                                      const std::vector<Setting>& settings);

}  // namespace conddp
