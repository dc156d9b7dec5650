#pragma once

#include <memory>
#include <utility>
#include <vector>

#include "analysis/certificate/solution_claims.hpp"
#include "support/small_problems.hpp"

/// A one-step problem, and claims of an answer to it.
namespace conddp::testing {

/// One step x⁺ = x + u from the origin with cost effort · ½ ‖u − wish‖² and a constraint on its
/// end, which is soft if it has a weight.
inline ShootingProblem one_step(const std::vector<double>& wish, ConstraintKind kind,
                                const std::vector<double>& bounds, double weight = 0,
                                double effort = 1) {
  const int n = static_cast<int>(wish.size());
  const auto system = linear_system(Eigen::MatrixXd::Identity(n, n),
                                    Eigen::MatrixXd::Identity(n, n), Eigen::VectorXd::Zero(n));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_cost("effort", control_residual(n, n), {});
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  end->add_constraint(make_constraint("end", state_residual(end->manifold()), kind, 1,
                                      weight > 0 ? Softness::l1 : Softness::hard));
  std::vector<double> cost = wish, constraint(n, 0.0);
  cost.push_back(effort);
  constraint.insert(constraint.end(), bounds.begin(), bounds.end());
  constraint.push_back(1);
  if (weight > 0) constraint.push_back(weight);
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1}, .cost_scale = {1}, .parameters = cost});
  return ShootingProblem(
      std::vector<double>(n, 0.0), std::move(phases),
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = constraint});
}

/// Claims of a step u that ends the motion, with equal costates and multipliers everywhere.
inline SolutionClaims claims_of(const ShootingProblem& problem, const Eigen::VectorXd& u,
                                const Eigen::VectorXd& multiplier, double cost) {
  SolutionClaims claims(problem);
  claims.times = problem.times();
  claims.converged = true;
  claims.status = "converged";
  claims.trajectory.u(0) = u;
  claims.trajectory.x(1) = u;
  claims.costates.colwise() = multiplier;
  claims.multipliers = multiplier;
  claims.cost = cost;
  claims.cost_by_name = {{"effort", cost}};
  claims.stationarity = claims.gap = claims.constraint = claims.complementarity = 0;
  return claims;
}

}  // namespace conddp::testing
