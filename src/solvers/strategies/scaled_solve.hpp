#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// A solve of a problem from a guess.
using SolveProblem = std::function<SolveResult(const ShootingProblem&, const SolverOptions&,
                                               const Trajectory& guess)>;

/// Calls `solve` for the problem with costs of the usual size (cost_scale) or, where its numbers
/// lie far apart, in units in which states, controls, rows and costs are about 1 (units_of); and
/// where that fails in the other way, if there are such units. A limit of iterations below the
/// default one is that of both. Returns the answer in the units of the problem, but for the
/// complementarity and, in the log, the penalties of constraints, regularisations and barriers,
/// which are those of the scaled problem, as the options are. In other units the log's gaps and
/// violations are those of the scaled problem, too, but for those of its first row, which are not
/// less than those of the guess in either unit, and of its last.
SolveResult solve_scaled(const ShootingProblem& problem, const SolverOptions& options,
                         const Trajectory& guess, const SolveProblem& solve);

}  // namespace conddp
