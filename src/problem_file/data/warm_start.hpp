#pragma once

#include <filesystem>

#include "problem_file/spec/spec.hpp"

namespace conddp {

/// Makes a former solution (solution.json or a CSV file) the initial guess of states and controls,
/// and of multipliers if a solution.json. It replaces the guess of the problem file. The path is
/// relative to the current folder; errors are reported at `place`.
void set_warm_start(const std::filesystem::path& file, const Place& place, ProblemSpec& spec);

}  // namespace conddp
