#include "solvers/globalization/open_gap_search.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// A step from an iterate with open gaps, and its step-length search.
struct Step {
  Step(const ShootingProblem& problem, const Trajectory& from)
      : bounds(problem),
        evaluator(problem),
        linearization(problem),
        gaps(problem),
        adjoint(problem, bounds),
        direction(problem, bounds, {.clamp_controls = true, .box_stage = true}),
        search(problem, bounds, true),
        trajectory(from) {
    for (int i = 0; i < problem.nx(); ++i) trajectory.x(0)[i] = problem.initial_state()[i];
    evaluator.differentiate(trajectory, linearization);
    gaps.set(linearization, true);
    EXPECT_LT(direction.find(linearization, trajectory, gaps, adjoint, {}), 0);
    merit.cost = linearization.total_cost();
    merit.gap_norm = gaps.norm();
    merit.slope = direction.step().slope();
    merit.slope_within_bounds = direction.qp().within_bounds();
    merit.penalty = search.weigh(merit, direction.curvature(linearization));
  }
  LineSearchResult run() {
    return search.run(evaluator, merit, linearization, direction, nullptr, trajectory);
  }
  /// Merit of the trajectory, evaluated independently of the search.
  double merit_value() {
    Evaluation evaluation(problem());
    evaluator.evaluate(trajectory, evaluation);
    return evaluation.cost.sum() + merit.penalty * evaluation.gap.lpNorm<1>();
  }
  const ShootingProblem& problem() const { return evaluator.problem(); }

  ControlBounds bounds;
  Evaluator evaluator;
  Linearization linearization;
  Gaps gaps;
  Adjoint adjoint;
  MeritModel merit;
  Direction direction;
  OpenGapSearch search;
  Trajectory trajectory;
};

TEST(OpenGapSearch, WeightPaysForTheStep) {
  const ShootingProblem problem = testing::pendulum_swing_up();
  const ControlBounds bounds(problem);
  OpenGapSearch search(problem, bounds, false);
  const MeritModel costly{.gap_norm = 2, .slope = 3}, cheap{.gap_norm = 2, .slope = -9};
  // 3 + ½·7 = 6.5 is 0.65 · 5 · 2.
  EXPECT_DOUBLE_EQ(search.weigh(costly, 7), 5);
  EXPECT_DOUBLE_EQ(search.weigh(cheap, 7), 0);
  // Negative curvature does not reduce the weight.
  EXPECT_DOUBLE_EQ(search.weigh(costly, -7), 3 / 1.3);
}

TEST(OpenGapSearch, DecreaseMatchesTheMerit) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u})
    for (const double limit : {testing::kFree, 3.0}) {
      const ShootingProblem problem = testing::cartpole_swing_up(limit);
      Step step(problem, testing::random_guess(problem, seed, 0.5));
      ASSERT_GT(step.merit.gap_norm, 1);
      const LineSearchResult found = step.run();
      ASSERT_TRUE(found.accepted) << seed;
      EXPECT_GE(found.actual_decrease, 1e-4 * found.expected_decrease) << seed;
      EXPECT_NEAR(step.merit_value(), step.merit.value() - found.actual_decrease,
                  1e-9 * step.merit.value())
          << seed << ' ' << limit;
    }
}

// Rollouts that reach 0.6 of the model decrease have no rival; otherwise the better of both trials
// wins.
TEST(OpenGapSearch, TakesBetterOfRolloutAndLinearStep) {
  int straight = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const ShootingProblem problem = testing::cartpole_swing_up();
    Step step(problem, testing::random_guess(problem, seed, 0.1 * (1 + seed % 10)));
    const Trajectory from = step.trajectory;
    const LineSearchResult found = step.run();
    if (!found.accepted) continue;
    const MeritModel& merit = step.merit;
    const double alpha = found.step;
    SingleRollout rollout(problem);
    step.evaluator.roll_out(from, step.linearization.gap, step.direction.feedback(), alpha,
                            {.contract_gaps = true}, rollout);
    const double rolled =
        rollout.first_bad_knot >= 0
            ? -testing::kFree
            : merit.value() - rollout.cost - merit.penalty * (1 - alpha) * merit.gap_norm;
    const double curvature = std::max(step.direction.curvature(step.linearization), 0.0);
    double expected = rolled;
    if (!(rolled >= 0.6 * (-alpha * merit.merit_slope() - 0.5 * alpha * alpha * curvature))) {
      Trajectory linear = from;
      for (int k = 0; k <= problem.knots(); ++k) {
        linear.x(k) += alpha * step.direction.step().dx(k);
        if (k < problem.knots()) linear.u(k) += alpha * step.direction.step().du(k);
      }
      Evaluation evaluation(problem);
      step.evaluator.evaluate(linear, evaluation);
      const double direct =
          merit.value() - evaluation.cost.sum() - merit.penalty * evaluation.gap.lpNorm<1>();
      straight += direct > rolled;
      expected = std::max(rolled, direct);
    }
    EXPECT_NEAR(found.actual_decrease, expected, 1e-9 * merit.value()) << seed;
  }
  EXPECT_GE(straight, 1);
}

// Linear dynamics: the rollout equals the linear model step and needs no rival.
TEST(OpenGapSearch, QuadraticMinimumTakesOneTrial) {
  Eigen::MatrixXd A(2, 2), B(2, 1);
  A << 1, 0.1, 0, 1;
  B << 0, 0.1;
  const ShootingProblem problem =
      testing::tracking_problem(linear_system(A, B, Eigen::VectorXd::Zero(2)), Integrator::discrete,
                                8, 1, {1, -1}, {{0, 0}, {1, 1}, {0.5}, {3, 3}, false});
  Step step(problem, testing::random_guess(problem, 3));
  ASSERT_GT(step.merit.gap_norm, 1);
  const Trajectory from = step.trajectory;
  const LineSearchResult found = step.run();
  ASSERT_TRUE(found.accepted);
  EXPECT_EQ(found.step, 1);
  EXPECT_EQ(found.trials, 1);
  for (int k = 1; k <= problem.knots(); ++k)
    EXPECT_LT(
        (step.trajectory.x(k) - from.x(k) - step.direction.step().dx(k)).lpNorm<Eigen::Infinity>(),
        1e-12)
        << k;
}

// If the direction ignores active bounds, trials clamp the controls.
TEST(OpenGapSearch, ControlsRespectBoundsWithoutAnActiveSet) {
  int searches = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    const ShootingProblem problem = testing::cartpole_swing_up(0.5);
    Step step(problem, testing::random_guess(problem, seed, 0.5));
    if (!step.direction.qp().set_unknown()) continue;
    const LineSearchResult found = step.run();
    if (!found.accepted) continue;
    ++searches;
    const long lengths = 1 + std::lround(-std::log2(found.step));
    EXPECT_GE(found.trials, lengths) << seed;
    EXPECT_LE(found.trials, 2 * lengths) << seed;
    EXPECT_NEAR(step.merit_value(), step.merit.value() - found.actual_decrease,
                1e-9 * step.merit.value());
    for (int k = 0; k < problem.knots(); ++k) EXPECT_LE(std::abs(step.trajectory.u(k)[0]), 0.5);
  }
  EXPECT_GE(searches, 3);
}

TEST(OpenGapSearch, KeepsIterateIfNoStepPasses) {
  const ShootingProblem problem = testing::pendulum_swing_up();
  Step step(problem, testing::random_guess(problem, 1));
  const Trajectory from = step.trajectory;
  step.merit.slope = -1e9;  // an unattainable promise
  const LineSearchResult found = step.run();
  EXPECT_FALSE(found.accepted);
  for (int k = 0; k <= problem.knots(); ++k) EXPECT_EQ(step.trajectory.x(k), from.x(k)) << k;
}

}  // namespace
}  // namespace conddp
