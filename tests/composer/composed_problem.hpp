#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace conddp {

/// A problem as its file says it, and what the command line leaves out of it.
struct ComposedProblem {
  std::string body;  ///< what moves in it
  std::string text;  ///< YAML; relative paths lead to problems/
  std::vector<std::string> drop;
};

/// A small problem of random parts, the same for the same seed everywhere. What stands in the
/// tables of residuals, words, solvers, options and systems is taken from them.
ComposedProblem compose_problem(std::uint64_t seed);

}  // namespace conddp
