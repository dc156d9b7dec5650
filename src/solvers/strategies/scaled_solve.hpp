#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Calls `solve` for the problem with costs of the usual size (cost_scale), and returns its answer
/// in the unit of the problem's own costs, but for the complementarity and, in the log, the
/// penalties of constraints, regularisations and barriers, which are those of the scaled costs, as
/// the options are.
SolveResult solve_scaled(
    const ShootingProblem& problem, const SolverOptions& options,
    const std::function<SolveResult(const ShootingProblem&, const SolverOptions&)>& solve);

}  // namespace conddp
