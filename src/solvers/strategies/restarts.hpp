#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves from a guess with these options; the last argument ← by which solver.
using Solve =
    std::function<SolveResult(const Trajectory&, const SolverOptions&, const SolverInfo*&)>;

/// The spread of guesses far from a guess that did not serve: near ones lead to the same answer
/// (docs/measurements/hard_cases.md).
inline constexpr double kFarSpread = 1, kFartherSpread = 10;

/// Restarts after a failure at most.
inline constexpr int kMostRestarts = 20;

/// The guess of a start; 0: unchanged.
Trajectory start_of(const ShootingProblem& problem, const SolverOptions::Restarts& restarts,
                    const Trajectory& guess, int start);

/// What `result` is among the attempts of a solve.
Attempt attempt_of(const SolverInfo& solver, int start, const SolveResult& result,
                   const Objection& objection);

/// Solves from the guess (start 0) and from `options.restarts.count` random perturbations of it, in
/// so many threads, all within one time limit: starts that it leaves no time for are not made. The
/// answer is the cheapest one that converged, of answers equal in cost that of the first start;
/// where none converged it is that of the guess. It does not depend on the number of threads,
/// unless time runs out.
SolveResult solve_restarts(const ShootingProblem& problem, const SolverOptions& options,
                           const Trajectory& guess, int threads, const Solve& solve,
                           const SolverInfo*& used);

/// Of a problem that could not be solved from the guess: solves from up to 20 random perturbations
/// of it with this spread, one after the other until one converges to an answer
/// without doubts, or until the guess and four of them, and no others, have ended at the same least
/// violation. They share the limits of iterations and time, and `options.restarts.seed`. Where none
/// converges without doubts, the answer is the first that converged, or else `failed`; in each case
/// it has the record of its restarts.
SolveResult solve_from_elsewhere(const ShootingProblem& problem, const SolverOptions& options,
                                 const Trajectory& guess, SolveResult failed, double spread,
                                 const Solve& solve, const Doubt& doubt, const SolverInfo*& used);

}  // namespace conddp
