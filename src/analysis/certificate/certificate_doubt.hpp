#pragma once

#include <memory>
#include <string>
#include <vector>

#include "analysis/certificate/certificate.hpp"
#include "ocp/problem/node_values.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// Claims of an answer as the outputs state them. `values` are those of its trajectory, `options`
/// those of the solve.
SolutionClaims claims_of(const ShootingProblem& problem, const SolveResult& result,
                         const NodeValues& values, const SolverOptions& options);

/// Certificates that the outputs may take over, whose places have these names.
struct KnownCertificates {
  std::shared_ptr<CertificateMemory> memory = nullptr;
  std::vector<std::string> tangent_names = {};
};

/// Returns a function that raises the objection of the certificate to an answer solved with these
/// options. The last certificate is kept in `known`.
Doubt certificate_doubt(const SolverOptions& options, KnownCertificates known = {});

}  // namespace conddp
