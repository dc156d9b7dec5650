#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace conddp {

/// Text of a problem file and constraints dropped on the command line.
struct ComposedProblem {
  std::string body;  ///< name of its system
  std::string text;  ///< YAML; relative paths refer to problems/
  std::vector<std::string> drop;
};

/// A small random problem, reproducible by seed. Residuals, words, solvers, options, and systems
/// come from their tables.
ComposedProblem compose_problem(std::uint64_t seed);

}  // namespace conddp
