// Forged answers whose costates, gains, and multipliers were computed to make all figures agree:
// none is certified.
#include <random>

#include <Eigen/QR>
#include <gtest/gtest.h>

#include "analysis/certificate/lagrangian_gradient.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "output/report/certificate_report.hpp"
#include "support/sizes.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

/// Residuals of a simulated trajectory, except stationarity.
Evaluation evaluate(const ShootingProblem& problem, const Trajectory& trajectory) {
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(trajectory, evaluation);
  return evaluation;
}

/// Costates that null ∇_u L as far as possible, with constraint multipliers unchanged. A huge
/// claimed gain absorbs the rest of ∇_x L.
void solve_for_multipliers(const ShootingProblem& problem, SolveResult& result) {
  const Evaluation evaluation = evaluate(problem, result.trajectory);
  const auto derivatives = node_derivatives(problem, result.trajectory, evaluation.gap);
  for (int k = 0; k < problem.knots(); ++k) {
    const int nu = problem.nu(k), ndx = problem.ndx();
    const NodeDerivatives& d = derivatives[k];
    const Eigen::VectorXd wanted =
        -(d.cost +
          d.constraint.transpose() * result.constraint_multipliers.segment(
                                         problem.constraint_offset(k), d.constraint.rows()))
             .tail(nu);
    const Eigen::MatrixXd B = d.step.rightCols(nu).transpose();
    Eigen::VectorXd lambda = result.costates.col(k + 1);
    lambda += B.completeOrthogonalDecomposition().solve(Eigen::VectorXd(wanted - B * lambda));
    ASSERT_EQ(lambda.size(), ndx);
    result.costates.col(k + 1) = lambda;
  }
  const LagrangianGradient gradient =
      lagrangian_gradient(problem, derivatives, result.costates, result.constraint_multipliers);
  result.state_gradient = gradient.state;
  result.control_gradient = gradient.control;
  double stationarity = 0;
  for (const Eigen::VectorXd& g : gradient.control)
    if (g.size() > 0) stationarity = std::max(stationarity, g.lpNorm<Eigen::Infinity>());
  result.residuals.stationarity = stationarity;
}

/// Document of an answer whose controls are perturbed by at most `size` relative to themselves or
/// 1, with all dependent figures.
OrderedJson forged(const SolvedExample& answer, std::uint64_t seed, double size) {
  const ShootingProblem& problem = *answer.built.problem;
  std::mt19937_64 engine(seed);
  const auto random = [&] { return 2 * static_cast<double>(engine() >> 11) * 0x1p-53 - 1; };
  SolveResult result = *answer.result;
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i) {
      const KnotModel& model = *problem.knot(k).model;
      double& u = result.trajectory.u(k)[i];
      u = std::clamp(u + size * random() * std::max(1.0, std::abs(u)), model.control_lower()[i],
                     model.control_upper()[i]);
    }
  Evaluator(problem).simulate(result.trajectory);
  const Evaluation evaluation = evaluate(problem, result.trajectory);
  result.cost = evaluation.cost.sum();
  result.constraint_values = evaluation.constraint;
  solve_for_multipliers(problem, result);
  result.residuals.stationarity = std::min(
      result.residuals.stationarity, 0.5 * answer.spec.solver.options.tolerances.stationarity);
  result.residuals.gap = 0;
  result.residuals.complementarity = 0;
  result.feedback.K[problem.knots() / 2](0, 0) = 1e15;
  IterationRecord& last = result.log.back();
  last.cost = result.cost;
  last.gap = 0;
  last.stationarity = result.residuals.stationarity;
  const SolverInfo& solver = *find_solver(answer.spec.solver.name.value);
  return OrderedJson::parse(solution_json({answer.built, solver, result, {}}).dump());
}

/// Message of the status check.
std::string optimality_failure(const SolutionCertificate& certificate) {
  for (const Check& check : certificate.checks.checks)
    if (check.name == "status") return check.message;
  return "";
}

void expect_caught(const std::string& name, int count, double size, bool nulled) {
  const SolvedExample answer(name);
  ASSERT_EQ(answer.result->status, SolveStatus::converged);
  int disagreeing = 0;
  for (int seed = 1; seed <= count; ++seed) {
    const OrderedJson document = forged(answer, seed, size);
    const SolutionCertificate certificate = answer.judge(document);
    disagreeing += failures(certificate).find("[stationarity]") != std::string::npos;
    EXPECT_NE(optimality_failure(certificate).find("the reduced gradient"), std::string::npos)
        << name << " " << seed;
  }
  // If costates can null ∇_u L, the figures agree. Otherwise one in twenty may be so close to a
  // cone's kink that the last digits decide.
  if (nulled)
    EXPECT_EQ(disagreeing, 0) << name;
  else
    EXPECT_GE(20 * disagreeing, 19 * count) << name;
}

TEST(Forgery, PendulumIsCaught) {
  expect_caught("pendulum_swingup", kSmallSizes ? 5 : 90, 0.3, true);
}
TEST(Forgery, ArmIsCaught) { expect_caught("arm_reach", kSmallSizes ? 2 : 90, 0.3, true); }
TEST(Forgery, QuadrupedWithConesIsCaught) {
  // Torques that only load legs against each other move no state, so no costate can balance them.
  expect_caught("quadruped_trot_cones", kSmallSizes ? 1 : 20, 1e-3, false);
}

/// Zero controls, costates that null ∇_u L, and one huge gain, which once widened a tolerance.
TEST(Forgery, HangingPendulumIsCaughtByReducedGradient) {
  const SolvedExample answer("pendulum_swingup");
  const ShootingProblem& problem = *answer.built.problem;
  SolveResult result = *answer.result;
  for (int k = 0; k < problem.knots(); ++k) result.trajectory.u(k).setZero();
  Evaluator(problem).simulate(result.trajectory);
  result.cost = evaluate(problem, result.trajectory).cost.sum();
  solve_for_multipliers(problem, result);
  result.residuals.gap = 0;
  result.feedback.K[10](0, 0) = 1e15;
  result.log.back().cost = result.cost;
  result.log.back().gap = 0;
  result.log.back().stationarity = result.residuals.stationarity;
  const SolverInfo& solver = *find_solver(answer.spec.solver.name.value);
  const OrderedJson document =
      OrderedJson::parse(solution_json({answer.built, solver, result, {}}).dump());
  ASSERT_GT(document["cost"].get<double>(), 1000 * answer.result->cost);
  const SolutionCertificate certificate = answer.judge(document);
  const std::string found = failures(certificate);
  EXPECT_NE(optimality_failure(certificate).find("the reduced gradient"), std::string::npos)
      << certificate_table(certificate.checks);
  EXPECT_NE(found.find("[feedback]"), std::string::npos) << certificate_table(certificate.checks);
  EXPECT_GT(certificate.checks.optimality.stationarity, 1e-3);
  EXPECT_GT(certificate.checks.optimality.reduced_gradient, 1e-3);
}

}  // namespace
}  // namespace conddp
