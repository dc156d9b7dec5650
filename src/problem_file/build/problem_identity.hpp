#pragma once

#include <string>

#include "problem_file/build/build.hpp"

namespace conddp {

/// The SHA-256 of a problem, unperturbed and with all its constraints: of what its file and the
/// settings say of it (ProblemSpec::definition), and of the files with its robots and data.
std::string problem_sha256(const ProblemSpec& spec, const BuiltProblem& built);

}  // namespace conddp
