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

/// All that a solution is written from.
struct Solution {
  const ProblemSpec& spec;
  const BuiltProblem& built;
  const SolverInfo& solver;
  const SolveResult& result;
  std::vector<std::string> overrides;  ///< settings of the command line, as given
  std::vector<MeshRound> mesh = {};    ///< the grids, where the file has it refined
  Answer answer = Answer(spec, built, result);
};

}  // namespace conddp
