#pragma once

#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Throws std::invalid_argument if the options are not valid, or the solver does not support the
/// problem or the requested Hessian, segments or multipliers.
void check_options(const SolverInfo& solver, const ShootingProblem& problem,
                   const SolverOptions& options);

}  // namespace conddp
