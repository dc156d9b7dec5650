#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves a problem with one of several solvers; the last argument receives which one.
using SolveByFirst =
    std::function<SolveResult(const ShootingProblem&, SolverList, const SolverOptions&,
                              const Trajectory&, const SolverInfo*&)>;

/// Solves a problem along the homotopy `options.homotopy`. The problem at share 0 is solved from
/// the guess. Each further problem is solved from the last answer and its multipliers, by the
/// solver of the first one. Steps are doubled after a solve with no more iterations than the first
/// one, and halved after a failure.
///
/// max_iterations, max_time_s and `interrupted` cover all solves together. The first solve may take
/// half of the iterations; a step may take as many as all answers before it, and at least fifty. If
/// steps become too short, the remaining budget goes to the problem itself, from the last answer,
/// with all `candidates`. That answer is returned, converged or not. After an end by time or a
/// signal, the answer is the point reached so far, measured on the problem itself.
SolveResult solve_homotopy(const ShootingProblem& problem, SolverList candidates,
                           const SolverOptions& options, const Trajectory& guess,
                           const SolveByFirst& solve, const SolverInfo*& used);

}  // namespace conddp
