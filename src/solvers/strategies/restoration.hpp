#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

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
SolveResult solve_with_restoration(
    const ShootingProblem& problem, const SolverOptions& options, const Trajectory& guess,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve);

/// Examines an `infeasible` answer by minimizing only the violation from there (violation_problem).
/// The answer stands if the violation does not fall and the search ends at a minimum, no objection
/// is raised, and no iterate of its log is feasible. If the violation falls, the answer is that of
/// `solve` from the motion found, which is examined in the same way. Otherwise the status is
/// `line_search_failed`.
SolveResult confirm_infeasible(
    const ShootingProblem& problem, const SolverOptions& options, SolveResult result,
    const Doubt& doubt,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve,
    const std::function<SolveResult(const ShootingProblem&, const Trajectory&)>& minimize);

}  // namespace conddp
