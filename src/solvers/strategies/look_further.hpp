#pragma once

#include <functional>

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Solves by one solver from a guess; the last argument ← what speaks against the answer.
using SolveOnce = std::function<SolveResult(const SolverInfo&, const SolverOptions&,
                                            const Trajectory& guess, Objection&)>;

/// Looks for a better answer than `found`, which `used` has given: by the candidates that its
/// attempts do not have, from the guess, the last one first, and by the best one so far from random
/// perturbations of it, one after the other, until the work of all is `options.look_further`; an
/// attempt may take four times the iterations of the best one so far, at least fifty. An answer is
/// better that has no objection where the other one has, or that costs less by more than a
/// ten-thousandth. max_time_s and `interrupted` are of all together.
SolveResult look_further(const ShootingProblem& problem, SolverList candidates,
                         const SolverOptions& options, const Trajectory& guess, SolveResult found,
                         const SolveOnce& solve, const SolverInfo*& used);

}  // namespace conddp
