#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "output/solution/answer.hpp"
#include "problem_file/build/build.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// The value of `format` in a solution.json.
inline constexpr std::string_view kSolutionFormat = "conddp.solution/1";

/// Data for the files of a solution.
struct Solution {
  const ProblemSpec& spec;
  const BuiltProblem& built;
  const SolverInfo& solver;
  const SolveResult& result;
  std::vector<std::string> overrides;  ///< command-line settings, as given
  std::vector<MeshRound> mesh = {};    ///< the grids, if the file requests refinement
  Answer answer = Answer(spec, built, result);
};

}  // namespace conddp
