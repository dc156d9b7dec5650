#pragma once

#include <memory>

#include "analysis/certificate/certificate.hpp"
#include "ocp/problem/node_values.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Claims of an answer as the outputs state them. `values` are those of its trajectory, `options`
/// those of the solve.
SolutionClaims claims_of(const ShootingProblem& problem, const SolveResult& result,
                         const NodeValues& values, const SolverOptions& options);

/// Returns a function that raises the objection of the certificate to an answer solved with these
/// options. `memory` caches the most expensive part, the second-order model.
Doubt certificate_doubt(const SolverOptions& options,
                        std::shared_ptr<SecondOrderMemory> memory = nullptr);

}  // namespace conddp
