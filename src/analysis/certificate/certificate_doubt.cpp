#include "analysis/certificate/certificate_doubt.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include <fmt/format.h>

#include "ocp/problem/by_name.hpp"
#include "solvers/common/control_bounds.hpp"

namespace conddp {
namespace {

/// Share of the cost that may be left to gain without a further solve.
constexpr double kMostLeft = 1e-7;

template <class Matrix>
Matrix finite_or_open(const Eigen::PlainObjectBase<Matrix>& numbers) {
  return numbers.unaryExpr([](double number) { return conddp::finite_or_open(number); });
}
template <class Matrix>
std::vector<Matrix> finite_or_open(const std::vector<Matrix>& list) {
  std::vector<Matrix> open;
  for (const Matrix& numbers : list) open.push_back(finite_or_open(numbers));
  return open;
}

}  // namespace

double finite_or_open(double number) {
  return std::isfinite(number) ? number : SolutionClaims::kOpen;
}

std::vector<Eigen::VectorXd> bound_multipliers(const ShootingProblem& problem,
                                               const SolveResult& result, bool upper) {
  const ControlBounds bounds(problem);
  std::vector<Eigen::VectorXd> multipliers;
  for (int k = 0; k < problem.knots(); ++k) {
    Eigen::VectorXd& own = multipliers.emplace_back(Eigen::VectorXd::Zero(problem.nu(k)));
    if (result.control_gradient.empty()) continue;
    for (int i = 0; i < problem.nu(k); ++i) {
      const double u = result.trajectory.u(k)[i], gradient = result.control_gradient[k][i];
      if (upper ? bounds.at_upper(k, i, u) : bounds.at_lower(k, i, u))
        own[i] = std::max(0.0, upper ? -gradient : gradient);
    }
  }
  return multipliers;
}

SolutionClaims claims_of(const ShootingProblem& problem, const SolveResult& result,
                         const NodeValues& values, const SolverOptions& options) {
  SolutionClaims claims(problem);
  claims.trajectory = result.trajectory;
  for (int k = 0; k <= problem.knots(); ++k) {
    claims.trajectory.x(k) = finite_or_open(Eigen::VectorXd(result.trajectory.x(k)));
    if (k < problem.knots())
      claims.trajectory.u(k) = finite_or_open(Eigen::VectorXd(result.trajectory.u(k)));
  }
  for (const double time : problem.times(result.trajectory))
    claims.times.push_back(finite_or_open(time));
  claims.converged = result.status == SolveStatus::converged;
  claims.status = to_string(result.status);
  claims.cost = finite_or_open(result.cost);
  for (const auto& [name, cost] : cost_by_name(problem, values))
    claims.cost_by_name.emplace_back(name, finite_or_open(cost));
  claims.stationarity = finite_or_open(result.residuals.stationarity);
  claims.gap = finite_or_open(result.residuals.gap);
  claims.constraint = finite_or_open(result.residuals.constraint);
  claims.complementarity = finite_or_open(result.residuals.complementarity);
  claims.tolerances = options.tolerances;
  claims.costates = finite_or_open(result.costates);
  claims.state_gradient = finite_or_open(result.state_gradient);
  claims.lower_multipliers = finite_or_open(bound_multipliers(problem, result, false));
  claims.upper_multipliers = finite_or_open(bound_multipliers(problem, result, true));
  claims.multipliers = finite_or_open(result.constraint_multipliers);
  claims.gains = finite_or_open(result.feedback.K);
  claims.feedforward = finite_or_open(result.feedback.k);
  if (result.feedback_regularization)
    claims.gain_regularization = finite_or_open(*result.feedback_regularization);
  return claims;
}

Doubt certificate_doubt(const SolverOptions& options, std::shared_ptr<LastJudged> last,
                        std::vector<std::string> tangent_names) {
  return [options, last = std::move(last), tangent_names = std::move(tangent_names)](
             const ShootingProblem& problem, const SolveResult& result) {
    const NodeValues values(problem, result.trajectory);
    SolutionClaims claims = claims_of(problem, result, values, options);
    claims.tangent_names = tangent_names;
    Certificate certificate = certify(problem, claims, values);
    if (last) last->emplace(std::move(claims), certificate);
    Objection objection;
    if (certificate.second_order) {
      SecondOrder& model = *certificate.second_order;
      objection.excess = model.share() / kMostLeft;
      objection.descent = std::move(model.direction);
      objection.of_problem = !model.doubtful.empty();
      if (objection.excess > 1)
        objection.text = fmt::format("a Newton step would gain {:.2g} of its cost", model.share());
      if (model.hidden_share() > kMostLeft || model.kink) objection.text = certificate.curvature;
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

Certificate certify(const ShootingProblem& problem, const SolutionClaims& claims,
                    const NodeValues& values, const LastJudged* last) {
  const auto numbers = [](const SolutionClaims& c) {
    return std::tie(c.trajectory, c.status, c.cost, c.stationarity, c.gap, c.constraint,
                    c.complementarity, c.costates, c.state_gradient, c.lower_multipliers,
                    c.upper_multipliers, c.multipliers, c.gains, c.feedforward,
                    c.gain_regularization, c.tolerances.stationarity, c.tolerances.gap,
                    c.tolerances.constraint, c.tolerances.complementarity,
                    c.tolerances.cost_decrease, c.tangent_names);
  };
  if (last != nullptr && *last && numbers((*last)->claims) == numbers(claims))
    return (*last)->certificate;
  return certify(problem, claims, values);
}

}  // namespace conddp
