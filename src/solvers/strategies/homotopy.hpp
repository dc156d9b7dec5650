#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves a problem by one of some solvers; the last argument ← which.
using SolveByFirst =
    std::function<SolveResult(const ShootingProblem&, SolverList, const SolverOptions&,
                              const Trajectory&, const SolverInfo*&)>;

/// Comes to an answer along the problems of `options.homotopy`: that at share 0 is solved from the
/// guess, each further one from the last answer and its multipliers, by the solver that solved the
/// first one. Steps are doubled after a solve with no more iterations than the first one, halved
/// after one that failed. max_iterations, max_time_s and `interrupted` are of all solves together:
/// the first solve may take half of the iterations, a step as many as all answers before it, at
/// least fifty. Where steps become too short, what is left is spent on the problem itself, from
/// where the way got to, by all `candidates`: its answer counts, converged or not. After an end by
/// time or a signal that is what was reached so far, measured at the problem itself.
SolveResult solve_homotopy(const ShootingProblem& problem, SolverList candidates,
                           const SolverOptions& options, const Trajectory& guess,
                           const SolveByFirst& solve, const SolverInfo*& used);

}  // namespace conddp
