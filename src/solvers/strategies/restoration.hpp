#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Whether a solve ended for no other reason than that it found no way on, at a point that violates
/// a constraint: restorations of feasibility may find one.
bool got_stuck(const SolveResult& result, const SolverOptions& options);

/// A trajectory near `start` that satisfies the hard constraints better, or violates them least: a
/// minimum of cost + ½ρ Σ‖d‖², with d the distances from their sets, for a ρ that grows; from the
/// controls alone unless the motion that they give is far worse than the states. The status is
/// `converged` where the violation is under its tolerance or a hundredth of what it was,
/// `infeasible` at a point of least violation (ViolationSlope), at which multipliers and co-states
/// are those of the least ρ that showed it. Not of problems with complementary pairs.
SolveResult restore_feasibility(const ShootingProblem& problem, const SolverOptions& options,
                                const Trajectory& start);

/// Solves by `solve`, and wherever that ends without a step, or calls the problem infeasible, at a
/// violated constraint, restores feasibility and solves again from there, with a first penalty
/// between the first one of all and the largest that was needed. A restoration alone can
/// say `infeasible`: where there is none, or it decides nothing, the status is
/// `line_search_failed`. Limits are of all together.
SolveResult solve_with_restoration(
    const ShootingProblem& problem, const SolverOptions& options, const Trajectory& guess,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve);

/// An answer that says `infeasible`, after the violation alone has been minimised from there
/// (violation_problem): it stays where that does not lower the violation and ends at a minimum, no
/// doubt is raised, and no iterate of its log is feasible. Where the violation falls, the answer is
/// that of `solve` from the motion found, looked into likewise. Else the status is
/// `line_search_failed`.
SolveResult confirm_infeasible(
    const ShootingProblem& problem, const SolverOptions& options, SolveResult result,
    const Doubt& doubt,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve,
    const std::function<SolveResult(const ShootingProblem&, const Trajectory&)>& minimize);

}  // namespace conddp
