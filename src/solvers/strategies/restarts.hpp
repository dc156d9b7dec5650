#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves from a guess with these options; the last argument receives the solver.
using Solve =
    std::function<SolveResult(const Trajectory&, const SolverOptions&, const SolverInfo*&)>;

/// Spread of guesses far from a failed guess: near ones lead to the same answer
/// (docs/measurements/hard_cases.md).
inline constexpr double kFarSpread = 1, kFartherSpread = 10;

/// Maximum number of restarts after a failure.
inline constexpr int kMostRestarts = 20;

/// Guess of a start; start 0 is the guess itself.
Trajectory start_of(const ShootingProblem& problem, const SolverOptions::Restarts& restarts,
                    const Trajectory& guess, int start);

/// Record of `result` among the attempts of a solve.
Attempt attempt_of(const SolverInfo& solver, int start, const SolveResult& result,
                   const Objection& objection);

/// Solves from the guess (start 0) and from `options.restarts.count` random perturbations of it, in
/// this number of threads, all within one time limit. Starts without remaining time are not made.
/// The answer is the cheapest one that converged; of equal costs, that of the first start. If no
/// start converged, it is that of the guess. It does not depend on the number of threads, unless
/// time runs out.
SolveResult solve_restarts(const ShootingProblem& problem, const SolverOptions& options,
                           const Trajectory& guess, int threads, const Solve& solve,
                           const SolverInfo*& used);

/// Solves a problem that could not be solved from the guess, from up to 20 random perturbations of
/// the guess with this spread. It stops when one converges to an answer without objections, or when
/// the guess and four perturbations, and no others, have ended at the same least violation. All
/// share the limits of iterations and time, and `options.restarts.seed`. If none converges without
/// objections, the answer is the first that converged, or else `failed`. Each answer has the record
/// of its restarts.
SolveResult solve_from_elsewhere(const ShootingProblem& problem, const SolverOptions& options,
                                 const Trajectory& guess, SolveResult failed, double spread,
                                 const Solve& solve, const Doubt& doubt, const SolverInfo*& used);

}  // namespace conddp
