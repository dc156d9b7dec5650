#pragma once

#include <functional>

#include "solvers/common/options.hpp"
#include "solvers/common/solve_result.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// `solve`, and where its converged answer meets an objection, further solves from that answer:
/// with smaller tolerances where too much is left, from a point along the descent at a saddle. They
/// are one solve to the caller. The answer is the last one that converged and is no worse;
/// `remaining` is what speaks against it.
SolveResult solve_answering(
    const ShootingProblem& problem, const SolverOptions& options, const Trajectory& guess,
    const Doubt& doubt, Objection& remaining,
    const std::function<SolveResult(const SolverOptions&, const Trajectory&)>& solve);

}  // namespace conddp
