#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "batch/plan/problem_family.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// The answer for a file with `mesh`, on its last grid.
struct RefinedSolve {
  std::optional<ProblemInstance> instance;  ///< on that grid; nothing if it is the first grid
  SolveResult result;
  std::vector<MeshRound> rounds;
  std::string setting;  ///< setting of that grid, in `--set` syntax
};

/// Builds the problem on a given grid; returns nothing if it cannot be built.
using BuildOnGrid = std::function<std::optional<ProblemInstance>(const Setting& grid)>;

/// Continues from the answer on the first grid, as `conddp solve` does. `options.max_time_s`
/// applies to the subsequent grids. `solver` is the solver that found the answer.
RefinedSolve refine(const ProblemInstance& first, const SolveResult& result,
                    const std::vector<const SolverInfo*>& candidates, SolverOptions options,
                    const BuildOnGrid& build, const SolverInfo*& solver);

/// A message about a grid that is too coarse; empty if it is as fine as the file requires.
std::string too_coarse(const RefinedSolve& solve, const ProblemSpec& spec);

}  // namespace conddp
