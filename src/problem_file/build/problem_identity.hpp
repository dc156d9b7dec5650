#pragma once

#include <string>

#include "problem_file/build/build.hpp"

namespace conddp {

/// SHA-256 of a problem, unperturbed and with all its constraints. It covers the content of the
/// file and its settings (ProblemSpec::definition), and the files with robots and data.
std::string problem_sha256(const ProblemSpec& spec, const BuiltProblem& built);

}  // namespace conddp
