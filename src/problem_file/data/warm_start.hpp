#pragma once

#include <filesystem>

#include "problem_file/spec/spec.hpp"

namespace conddp {

/// Makes a former solution (solution.json, or a CSV file) the first guess of states and controls,
/// and of multipliers where it has them, instead of what the problem file says about it. The path
/// is relative to the current folder; what is wrong with the file is reported at `place`.
void set_warm_start(const std::filesystem::path& file, const Place& place, ProblemSpec& spec);

}  // namespace conddp
