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

/// The answer of a file with `mesh` on its last grid.
struct RefinedSolve {
  std::optional<ProblemInstance> instance;  ///< with that grid; nothing: it is the first one
  SolveResult result;
  std::vector<MeshRound> rounds;
  std::string setting;  ///< of that grid, as --set takes it
};

/// The problem with the setting of a grid; nothing where it cannot be built.
using BuildOnGrid = std::function<std::optional<ProblemInstance>(const Setting& grid)>;

/// Goes on from the answer on the first grid as `conddp solve` does. `options.max_time_s` is for
/// the grids that follow. `solver`: which one gave the answer.
RefinedSolve refine(const ProblemInstance& first, const SolveResult& result,
                    const std::vector<const SolverInfo*>& candidates, SolverOptions options,
                    const BuildOnGrid& build, const SolverInfo*& solver);

/// What there is to say of a grid that is too coarse; empty where it is as fine as the file asks.
std::string too_coarse(const RefinedSolve& solve, const ProblemSpec& spec);

}  // namespace conddp
