#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves by one solver from a guess; the last argument ← what speaks against the answer.
using SolveOnce = std::function<SolveResult(const SolverInfo&, const SolverOptions&,
                                            const Trajectory& guess, Objection&)>;

/// Share of the cost that a better answer costs less: more than what tolerances leave open.
inline constexpr double kLessCost = 1e-4;

/// Looks for a better answer than `found`, which `used` has given: by the candidates that its
/// attempts do not have, from the guess, and then by the best one so far from two random
/// perturbations of it, side by side in `options.threads`, while the work of all is less than
/// `options.look_further`, which may be 0; an attempt may take four times the iterations of the
/// best one so far, at least fifty. Where all jump, further perturbations follow, twenty in all,
/// within `options.max_iterations`. An answer is better that does not jump where the other one
/// does, or that costs less by more than a ten-thousandth; one without objections may cost as much
/// as one with some. max_time_s and `interrupted` are of all together.
SolveResult look_further(const ShootingProblem& problem, SolverList candidates,
                         const SolverOptions& options, const Trajectory& guess, SolveResult found,
                         const SolveOnce& solve, const SolverInfo*& used);

}  // namespace conddp
