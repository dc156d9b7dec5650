#pragma once

#include "problem_file/build/build.hpp"

namespace conddp {

/// Builds the problem of a spec with its homotopy, if it has one (build_without_homotopy).
std::optional<BuiltProblem> build_problem(const ProblemSpec& spec, const BuildOptions& options,
                                          Diagnostics& out);

}  // namespace conddp
