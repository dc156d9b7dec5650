#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"

namespace conddp {

/// Solves a problem from a guess.
using SolveProblem = std::function<SolveResult(const ShootingProblem&, const SolverOptions&,
                                               const Trajectory& guess)>;

/// Calls `solve` for a scaled problem. Its costs have the usual size (cost_scale) or, if its
/// numbers lie far apart, its states, controls, rows and costs are about 1 (units_of). If that
/// fails and such units exist, the other scaling is tried. A limit of iterations below the default
/// covers both.
///
/// The answer is in the units of the problem, except for the complementarity and, in the log,
/// constraint penalties, regularizations and barriers. These are those of the scaled problem, as
/// the options are. In other units, gaps and violations in the log are those of the scaled problem,
/// too, except in its first and last rows. In the first row, they are no less than those of the
/// guess in either unit.
SolveResult solve_scaled(const ShootingProblem& problem, const SolverOptions& options,
                         const Trajectory& guess, const SolveProblem& solve);

}  // namespace conddp
