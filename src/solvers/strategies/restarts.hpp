#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves from a guess with these options; the last argument ← by which solver.
using Solve =
    std::function<SolveResult(const Trajectory&, const SolverOptions&, const SolverInfo*&)>;

/// Solves from the guess (start 0) and from `options.restarts.count` random perturbations of it, in
/// so many threads, all within one time limit: starts that it leaves no time for are not made. The
/// answer is the cheapest one that converged, of answers equal in cost that of the first start;
/// where none converged it is that of the guess. It does not depend on the number of threads,
/// unless time runs out.
SolveResult solve_restarts(const ShootingProblem& problem, const SolverOptions& options,
                           const Trajectory& guess, int threads, const Solve& solve,
                           const SolverInfo*& used);

}  // namespace conddp
