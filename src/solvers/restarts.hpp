#pragma once

#include <functional>

#include "solvers/options.hpp"
#include "solvers/solve_result.hpp"

namespace conddp {

/// The guess from which a solve ends best, of the given one and `count` random perturbations of it:
/// each is tried in a process of its own, as many at once as there are threads, for solvers that
/// cannot run twice in one process. The same seed gives the same guess. A process that dies counts
/// as a solve that failed.
Trajectory best_start(const ShootingProblem& problem, const SolverOptions& options,
                      const Trajectory& guess,
                      const std::function<SolveResult(const Trajectory&)>& solve);

}  // namespace conddp
