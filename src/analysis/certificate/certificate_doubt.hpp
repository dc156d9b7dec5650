#pragma once

#include <memory>

#include "analysis/certificate/certificate.hpp"
#include "ocp/problem/node_values.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// What an answer claims, as outputs state it. `values` are those of its trajectory, `options`
/// those of the solve.
SolutionClaims claims_of(const ShootingProblem& problem, const SolveResult& result,
                         const NodeValues& values, const SolverOptions& options);

/// What the certificate of an answer denies that was solved with these options. `memory` keeps what
/// it took longest to find.
Doubt certificate_doubt(const SolverOptions& options,
                        std::shared_ptr<SecondOrderMemory> memory = nullptr);

}  // namespace conddp
