#include "solvers/sampling/sampling.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "support/expression_systems.hpp"
#include "support/small_problems.hpp"

namespace conddp::testing {
namespace {

/// Linear splines with this number of nodes, one per control.
ControlSplines linear_splines(const ShootingProblem& problem, const Trajectory& nominal, int nodes,
                              double scale) {
  ControlSplines splines(problem, nominal);
  for (int i = 0; i < problem.nu(0); ++i) {
    const int channel = splines.add_channel(nodes, scale);
    for (int k = 0; k < problem.knots(); ++k) {
      const double at = static_cast<double>(k) / (problem.knots() - 1) * (nodes - 1);
      std::vector<double> weights(nodes);
      for (int j = 0; j < nodes; ++j) weights[j] = std::max(0.0, 1 - std::abs(at - j));
      splines.add_entry(k, i, channel, weights);
    }
  }
  return splines;
}

SampledTrajectory search(const ShootingProblem& problem, const SamplingOptions& options,
                         double scale) {
  const Trajectory nominal = problem.create_trajectory();
  return search_controls(linear_splines(problem, nominal, 5, scale), options);
}

/// Cost of a trajectory of a problem without constraints.
double cost_of(const ShootingProblem& problem, const Trajectory& trajectory) {
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(trajectory, evaluation);
  return evaluation.cost.sum();
}

class Sampling : public ::testing::TestWithParam<SamplingMethod> {};

TEST_P(Sampling, IsTheSameForAnyNumberOfThreads) {
  const ShootingProblem problem = cartpole_swing_up(20);
  const SamplingOptions one{.method = GetParam(), .samples = 37, .rounds = 25};
  SamplingOptions four = one;
  four.threads = 4;
  const SampledTrajectory a = search(problem, one, 20), b = search(problem, four, 20);
  ASSERT_TRUE(a.found);
  EXPECT_EQ(a.trajectory, b.trajectory);
  EXPECT_EQ(a.value.cost, b.value.cost);
}

TEST_P(Sampling, FindsABetterMotionWithinBounds) {
  const ShootingProblem problem = pendulum_swing_up(3);
  const SampledTrajectory found = search(problem, {.method = GetParam(), .rounds = 20}, 3);
  ASSERT_TRUE(found.found);
  EXPECT_EQ(found.rollouts, 20 * 128);
  Trajectory nominal = problem.create_trajectory();
  ASSERT_LT(Evaluator(problem).simulate(nominal), 0);
  EXPECT_LT(found.value.cost, 0.85 * cost_of(problem, nominal));
  double largest = 0;
  for (int k = 0; k < problem.knots(); ++k)
    largest = std::max(largest, found.trajectory.u(k).lpNorm<Eigen::Infinity>());
  EXPECT_LE(largest, 3);
  EXPECT_GT(largest, 1);
}

TEST_P(Sampling, IsDifferentWithAnotherSeed) {
  const ShootingProblem problem = pendulum_swing_up(3);
  SamplingOptions options{.method = GetParam(), .samples = 8, .rounds = 10};
  const SampledTrajectory first = search(problem, options, 3);
  ASSERT_TRUE(first.found);
  options.seed = 2;
  EXPECT_NE(first.trajectory, search(problem, options, 3).trajectory);
}

INSTANTIATE_TEST_SUITE_P(Methods, Sampling,
                         ::testing::Values(SamplingMethod::predictive, SamplingMethod::cem,
                                           SamplingMethod::mppi));

TEST(SamplingRollouts, HaveTheCostOfASimulation) {
  const ShootingProblem problem = quadrotor_move(0, 5);
  const Trajectory nominal = constant_controls(problem, 2.5);
  const ControlSplines splines = linear_splines(problem, nominal, 3, 1);
  RolloutValues rollouts(splines, 2);
  const Eigen::MatrixXd theta = Eigen::MatrixXd::Random(splines.parameters(), 11);
  std::vector<RolloutValue> values(11);
  rollouts.evaluate(theta, values);
  Trajectory trajectory;
  for (int i = 0; i < 11; ++i) {
    ASSERT_TRUE(rollouts.roll_out(theta.col(i).data(), trajectory));
    EXPECT_NEAR(values[i].cost, cost_of(problem, trajectory), 1e-9 * std::abs(values[i].cost));
    EXPECT_EQ(values[i].violation, 0);
  }
}

TEST(SamplingRollouts, PassThroughTheNodesOfTheirSplines) {
  const ShootingProblem problem = pendulum_swing_up(3);
  const Trajectory nominal = constant_controls(problem, 0.5);
  const int last = problem.knots() - 1;
  const ControlSplines splines = linear_splines(problem, nominal, 2, 1);
  const double theta[] = {-1, 7};
  double u = 0;
  splines.controls(0, theta, &u);
  EXPECT_EQ(u, -0.5);
  splines.controls(last, theta, &u);
  EXPECT_EQ(u, 3);  // clamped
}

/// x⁺ = x + u + a term that is not finite from u = 1 on.
ShootingProblem one_sided(double start) {
  const auto system = expression_system({.kind = SystemKind::discrete,
                                         .states = expression_numbers({"x"}),
                                         .controls = expression_columns({"u"}),
                                         .equations = {{"x", "x + u + 1e-9*log(1 - u)"}}});
  return tracking_problem(system, Integrator::discrete, 10, 1, {start},
                          {.goal = {0}, .q = {1}, .r = {0.1}, .qf = {10}});
}

TEST(SamplingRollouts, ThatAreNotFiniteAreDiscarded) {
  const ShootingProblem problem = one_sided(-3);
  const SampledTrajectory found = search(problem, {.rounds = 10}, 2);
  ASSERT_TRUE(found.found);
  EXPECT_GT(found.discarded, 0);
  EXPECT_LT(found.discarded, found.rollouts);
  EXPECT_LT(std::abs(found.trajectory.x(10)[0]), 2);
}

TEST(SamplingRollouts, LeaveTheNominalIfNoneIsFinite) {
  const ShootingProblem problem = one_sided(std::nan(""));
  const SampledTrajectory found = search(problem, {.rounds = 2}, 2);
  EXPECT_FALSE(found.found);
  EXPECT_EQ(found.discarded, found.rollouts);
  EXPECT_EQ(found.trajectory.u(3)[0], 0);
}

}  // namespace
}  // namespace conddp::testing
