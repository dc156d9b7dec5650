#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "analysis/certificate/certificate.hpp"
#include "ocp/problem/node_values.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {

/// The number, open if it is not finite: documents cannot represent it.
double finite_or_open(double number);

/// Multipliers of the lower or upper control bounds, by knot: the part of the gradient that a bound
/// balances, nonnegative and zero away from the bound. Zero without a gradient.
std::vector<Eigen::VectorXd> bound_multipliers(const ShootingProblem& problem,
                                               const SolveResult& result, bool upper);

/// Claims of an answer as its document states them. `values` are those of its trajectory, `options`
/// those of the solve.
SolutionClaims claims_of(const ShootingProblem& problem, const SolveResult& result,
                         const NodeValues& values, const SolverOptions& options);

/// An answer with its certificate.
struct JudgedAnswer {
  SolutionClaims claims;
  Certificate certificate;
};

/// The certificate of the answer judged last, or null. It holds for the same answer only.
using LastJudged = std::optional<JudgedAnswer>;

/// Returns a function that raises the objection of the certificate to an answer solved with these
/// options. If `last` is given, the answer judged last is kept there, with these names in places.
Doubt certificate_doubt(const SolverOptions& options, std::shared_ptr<LastJudged> last = nullptr,
                        std::vector<std::string> tangent_names = {});

/// The certificate of an answer with these claims: that of `last` if the answers are equal in every
/// number, otherwise a new one.
Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims,
                    const NodeValues& values, const LastJudged* last);

}  // namespace conddp
