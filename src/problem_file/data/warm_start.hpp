#pragma once

#include <string>

#include "problem_file/spec/spec.hpp"

namespace conddp {

/// Makes a former solution (solution.json, or a CSV file) the first guess of states and controls,
/// and of multipliers where it has them, instead of what the problem file says about it. The path
/// is relative to the current folder.
void set_warm_start(const std::string& file, ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
