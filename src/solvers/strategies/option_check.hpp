#pragma once

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Throws std::invalid_argument where the options are not valid, or the solver does not support the
/// problem, the Hessian, the segments or the multipliers that they ask for.
void check_options(const SolverInfo& solver, const ShootingProblem& problem,
                   const SolverOptions& options);

}  // namespace conddp
