#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves with one solver from a guess; the last argument receives the objection to the answer.
using SolveOnce = std::function<SolveResult(const SolverInfo&, const SolverOptions&,
                                            const Trajectory& guess, Objection&)>;

/// Minimum relative cost decrease of a better answer, larger than tolerances leave open.
inline constexpr double kLessCost = 1e-4;

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
