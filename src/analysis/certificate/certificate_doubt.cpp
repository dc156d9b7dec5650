#include "analysis/certificate/certificate_doubt.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "ocp/problem/by_name.hpp"
#include "solvers/common/control_bounds.hpp"

namespace conddp {
namespace {

/// Share of the cost that may be left to gain without a further solve.
constexpr double kMostLeft = 1e-7;

/// Claims multipliers of the control bounds: the part of the gradient that a bound balances.
void claim_bounds(const ShootingProblem& problem, const SolveResult& result,
                  SolutionClaims& claims) {
  const ControlBounds bounds(problem);
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i) {
      const double u = result.trajectory.u(k)[i], gradient = result.control_gradient[k][i];
      if (bounds.at_lower(k, i, u)) claims.lower_multipliers[k][i] = std::max(0.0, gradient);
      if (bounds.at_upper(k, i, u)) claims.upper_multipliers[k][i] = std::max(0.0, -gradient);
    }
}

}  // namespace

SolutionClaims claims_of(const ShootingProblem& problem, const SolveResult& result,
                         const NodeValues& values, const SolverOptions& options) {
  SolutionClaims claims(problem);
  claims.trajectory = result.trajectory;
  claims.times = problem.times(result.trajectory);
  claims.converged = result.status == SolveStatus::converged;
  claims.status = to_string(result.status);
  claims.cost = result.cost;
  claims.cost_by_name = cost_by_name(problem, values);
  claims.stationarity = result.residuals.stationarity;
  claims.gap = result.residuals.gap;
  claims.constraint = result.residuals.constraint;
  claims.complementarity = result.residuals.complementarity;
  claims.tolerances = options.tolerances;
  claims.costates = result.costates;
  claims.state_gradient = result.state_gradient;
  claim_bounds(problem, result, claims);
  claims.multipliers = result.constraint_multipliers;
  claims.gains = result.feedback.K;
  claims.feedforward = result.feedback.k;
  if (result.feedback_regularization) claims.gain_regularization = *result.feedback_regularization;
  claims.gain_regularization_kind = options.regularization.kind;
  return claims;
}

Doubt certificate_doubt(const SolverOptions& options, KnownCertificates known) {
  return [options, known = std::move(known)](const ShootingProblem& problem,
                                             const SolveResult& result) {
    const NodeValues values(problem, result.trajectory);
    SolutionClaims claims = claims_of(problem, result, values, options);
    claims.tangent_names = known.tangent_names;
    Certificate certificate = certify(problem, claims, values);
    if (known.memory) known.memory->keep(std::move(claims), certificate);
    Objection objection;
    if (certificate.second_order) {
      SecondOrder& model = *certificate.second_order;
      objection.excess = model.share() / kMostLeft;
      objection.descent = std::move(model.direction);
      if (objection.excess > 1)
        objection.text = fmt::format("a Newton step would gain {:.2g} of its cost", model.share());
      if (model.hidden_share() > kMostLeft) objection.text = certificate.curvature;
      if (!objection.descent.empty())
        objection.text = "it is not a minimum: " + certificate.curvature;
    }
    const auto wrong =
        std::ranges::find_if(certificate.checks, [](const Check& c) { return !c.holds; });
    if (wrong != certificate.checks.end())
      objection.text = fmt::format("its certificate fails ({}{}{})", wrong->name,
                                   wrong->message.empty() ? "" : ": ", wrong->message);
    return objection;
  };
}

}  // namespace conddp
