#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Strategies of solve(): each calls a function that solves, once or several times, with other
/// options, guesses, or problems.

/// Solves one problem with these options from a guess.
using SolveFrom = std::function<SolveResult(const SolverOptions&, const Trajectory& guess)>;
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

/// Options for a guess that nearly satisfies the constraints: the first penalty holds them.
SolverOptions options_near(const SolverOptions& options);

/// Calls `solve`. If the guess satisfies all constraints and the end is worse (a violation or a
/// larger cost), solves again from the guess. These solves have larger first penalties, if the
/// solver has any (`penalizes`). If that does not help, the answer is the guess, with status
/// `line_search_failed`, or `max_iterations` if these are used up. Ends by time, a signal or
/// divergence are returned unchanged. Limits cover all solves together.
SolveResult solve_keeping_guess(const SolverOptions& options, const Trajectory& guess,
                                bool penalizes, const SolveFrom& solve);

/// True if a solve ended only because it found no further step, at a point that violates a
/// constraint. Restorations of feasibility may find a step.
bool got_stuck(const SolveResult& result, const SolverOptions& options);

/// Finds a trajectory near `start` that satisfies the hard constraints better, or violates them
/// least. It minimizes cost + ½ρ Σ‖d‖² for growing ρ, where d are the distances from the
/// constraints' sets. It starts from the controls alone, unless their motion is far worse than the
/// states.
///
/// The status is `converged` if the violation is below its tolerance or a hundredth of its former
/// value. It is `infeasible` at a point of least violation (ViolationSlope); multipliers and
/// co-states are then those of the least ρ that showed it. Does not support problems with
/// complementary pairs.
SolveResult restore_feasibility(const ShootingProblem& problem, const SolverOptions& options,
                                const Trajectory& start);

/// Calls `solve`. Whenever it ends without a step, or as infeasible, at a violated constraint,
/// restores feasibility and solves again from there. The first penalty then lies between the
/// overall first one and the largest that was needed. Only a restoration can return `infeasible`.
/// Without one, or if it decides nothing, the status is `line_search_failed`. Limits cover all
/// solves together.
SolveResult solve_with_restoration(const ShootingProblem& problem, const SolverOptions& options,
                                   const Trajectory& guess, const SolveFrom& solve);

/// Examines an `infeasible` answer by minimizing only the violation from there (violation_problem).
/// The answer stands if the violation does not fall and the search ends at a minimum, no objection
/// is raised, and no iterate of its log is feasible. If the violation falls, the answer is that of
/// `solve` from the motion found, which is examined in the same way. Otherwise the status is
/// `line_search_failed`.
SolveResult confirm_infeasible(
    const ShootingProblem& problem, const SolverOptions& options, SolveResult result,
    const Doubt& doubt, const SolveFrom& solve,
    const std::function<SolveResult(const ShootingProblem&, const Trajectory&)>& minimize);

/// Calls `solve`. If its converged answer meets an objection, solves again from that answer: with
/// smaller tolerances if too much gain is left, from a point along the descent at a saddle. To the
/// caller, they are one solve. The answer is the last converged one that is not worse; `remaining`
/// is the objection to it.
SolveResult solve_answering(const ShootingProblem& problem, const SolverOptions& options,
                            const Trajectory& guess, const Doubt& doubt, Objection& remaining,
                            const SolveFrom& solve);

/// Solves from a guess with these options; the last argument receives the solver.
using Solve =
    std::function<SolveResult(const Trajectory&, const SolverOptions&, const SolverInfo*&)>;

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

/// Solves with one solver from a guess; the last argument receives the objection to the answer.
using SolveOnce = std::function<SolveResult(const SolverInfo&, const SolverOptions&,
                                            const Trajectory& guess, Objection&)>;

/// Looks for a better answer than `found`, which `used` has given. First it tries the candidates
/// without an attempt so far, from the guess; then the best solver so far, from two random
/// perturbations of the guess. These run in parallel in `options.threads`, while the total work is
/// below `options.look_further`, which may be 0. An attempt may take four times the iterations of
/// the best one so far, and at least fifty. If all answers jump, further perturbations follow,
/// twenty in total, within `options.max_iterations`.
///
/// An answer is better if it does not jump where the other one does, or if it costs less by more
/// than a ten-thousandth. An answer without objections may cost as much as one with objections.
/// max_time_s and `interrupted` cover all solves together.
SolveResult look_further(const ShootingProblem& problem, SolverList candidates,
                         const SolverOptions& options, const Trajectory& guess, SolveResult found,
                         const SolveOnce& solve, const SolverInfo*& used);

}  // namespace conddp
