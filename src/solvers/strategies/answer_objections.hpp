#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Calls `solve`. If its converged answer meets an objection, solves again from that answer: with
/// smaller tolerances if too much gain is left, from a point along the descent at a saddle. To the
/// caller, they are one solve. The answer is the last converged one that is not worse; `remaining`
/// is the objection to it.
SolveResult solve_answering(
    const ShootingProblem& problem, const SolverOptions& options, const Trajectory& guess,
    const Doubt& doubt, Objection& remaining,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve);

}  // namespace conddp
