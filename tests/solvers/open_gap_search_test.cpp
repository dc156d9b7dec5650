#include "solvers/globalization/open_gap_search.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "solvers/constraints/augmented_lagrangian.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
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
    return search.run(evaluator, merit, linearization, direction, nullptr, 1, trajectory);
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

/// A step that satisfies the linear equations of gaps and rows, from an iterate with multipliers.
struct RowStep {
  explicit RowStep(const ShootingProblem& problem)
      : bounds(problem),
        evaluator(problem),
        linearization(problem),
        gaps(problem),
        adjoint(problem, bounds),
        lagrangian(problem, {}, MultiplierSchedule::by_the_sweep),
        direction(problem, bounds, {.null_space = true}),
        search(problem, bounds, false, true),
        trajectory(testing::random_guess(problem, 3, 0.3)) {
    lagrangian.start(Eigen::VectorXd::LinSpaced(problem.constraint_rows(), -1, 2));
    evaluator.differentiate(trajectory, linearization, &lagrangian.augmentation());
    lagrangian.measure(linearization.constraint);
    gaps.set(linearization, true);
    EXPECT_LT(direction.find(linearization, trajectory, gaps, adjoint, {}), 0);
    merit = {.cost = linearization.total_cost(),
             .gap_norm = search.gap_norm(linearization.gap, linearization.constraint),
             .slope = direction.step().slope()};
    double curvature = direction.curvature(linearization);
    search.leave_out(lagrangian.augmentation(), lagrangian.multipliers(), linearization.constraint,
                     merit.slope, curvature);
    merit.penalty = search.weigh(merit, curvature);
  }
  LineSearchResult run(double first_step = 1) {
    return search.run(evaluator, merit, linearization, direction, nullptr, first_step, trajectory);
  }
  double merit_of(const Trajectory& trial) {
    Evaluation evaluation(evaluator.problem());
    evaluator.evaluate(trial, evaluation);
    return evaluation.cost.sum() +
           merit.penalty * search.gap_norm(evaluation.gap, evaluation.constraint);
  }
  ControlBounds bounds;
  Evaluator evaluator;
  Linearization linearization;
  Gaps gaps;
  Adjoint adjoint;
  AugmentedLagrangian lagrangian;
  Direction direction;
  OpenGapSearch search;
  MeritModel merit;
  Trajectory trajectory;
};

ShootingProblem goal_problem() {
  const ShootingProblem swing = testing::cartpole_swing_up();
  return testing::with_constraints(swing, {testing::goal_constraint(swing, {0, M_PI, 0, 0})});
}

TEST(OpenGapSearchWithRows, MeritSlopeIsItsDerivative) {
  const ShootingProblem problem = goal_problem();
  RowStep step(problem);
  const double value = step.merit.value();
  EXPECT_NEAR(step.merit_of(step.trajectory), value, 1e-12 * value);
  EXPECT_LT(step.merit.merit_slope(), 0);
  const double length = 1e-6;
  Trajectory moved = step.trajectory;
  step.direction.step().apply(problem.manifold(), length, moved);
  EXPECT_NEAR((step.merit_of(moved) - value) / length, step.merit.merit_slope(),
              1e-3 * std::abs(step.merit.merit_slope()));
}

// Along the step the rows c vanish, and with them νᵀc and ½ ρ c² of the augmented Lagrangian.
TEST(OpenGapSearchWithRows, SlopeAndCurvatureLeaveOutTheAugmentation) {
  const ShootingProblem problem = goal_problem();
  const RowStep step(problem);
  const Eigen::VectorXd& off = step.linearization.constraint;  // bounds are zero
  double slope = 3, curvature = 5;
  step.search.leave_out(step.lagrangian.augmentation(), step.lagrangian.multipliers(), off, slope,
                        curvature);
  const double by_multipliers = step.lagrangian.multipliers().dot(off);
  const double by_penalties = step.lagrangian.augmentation().penalty.dot(off.cwiseAbs2());
  EXPECT_GT(std::abs(by_multipliers), 1e-3);
  EXPECT_GT(by_penalties, 1e-3);
  EXPECT_NEAR(slope, 3 + by_multipliers, 1e-12 * std::abs(slope));
  EXPECT_NEAR(curvature, 5 - by_penalties, 1e-12 * std::abs(curvature));
}

/// Rows of two knots and of the end; the middle rows are free.
TEST(OpenGapSearchWithRows, GapNormSumsGapsAndActiveRows) {
  const ShootingProblem free = testing::pendulum_swing_up();
  const int N = free.knots();
  const auto at = [&](int node, double value) {
    testing::Added added = testing::goal_constraint(free, {value, value});
    added.name = "row" + std::to_string(node);
    added.first = added.last = node;
    return added;
  };
  testing::Added open = at(3, 0);
  open.lower = {-testing::kFree, -testing::kFree};
  open.upper = {testing::kFree, testing::kFree};
  const ShootingProblem problem =
      testing::with_constraints(free, {at(1, 0), open, at(5, 0), at(N, 0)});
  const ControlBounds bounds(problem);
  const OpenGapSearch search(problem, bounds, false, true);
  Eigen::MatrixXd gap = Eigen::MatrixXd::Zero(2, N);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(problem.constraint_rows());
  gap(0, 0) = -2;
  gap(1, N - 1) = 3;
  EXPECT_EQ(search.gap_norm(gap, values), 5);
  for (const NodeConstraint& c : problem.constraints())
    for (int r = 0; r < 2; ++r) {
      values[c.row + r] = c.lower[r] - 7;
      if (c.node == 3) values[c.row + r] = 11;
      EXPECT_EQ(search.gap_norm(gap, values), c.node == 3 ? 5 : 12) << c.node << ' ' << r;
      values[c.row + r] = 0;
    }
}

TEST(OpenGapSearchWithRows, DecreaseMatchesTheMerit) {
  const ShootingProblem problem = goal_problem();
  RowStep step(problem);
  const LineSearchResult found = step.run();
  ASSERT_TRUE(found.accepted);
  EXPECT_NEAR(step.merit.value() - step.merit_of(step.trajectory), found.actual_decrease,
              1e-9 * step.merit.value());
}

// No rollout stays finite, so the step moves all knots at once.
TEST(OpenGapSearchWithRows, StraightStepReplacesDivergingRollouts) {
  const ShootingProblem problem = goal_problem();
  RowStep step(problem);
  step.direction.qp().feedback().k[0].setConstant(1e300);
  const Trajectory from = step.trajectory;
  const LineSearchResult found = step.run();
  ASSERT_TRUE(found.accepted);
  EXPECT_FALSE(found.rollout_cost);
  EXPECT_EQ(found.first_bad_knot, 0);
  Trajectory expected = from;
  step.direction.step().apply(problem.manifold(), found.step, expected);
  for (int k = 0; k <= problem.knots(); ++k)
    EXPECT_LT((step.trajectory.x(k) - expected.x(k)).norm(), 1e-12 * (1 + expected.x(k).norm()));
}

// Uphill from −10⁹, hidden by the merit's rounding: the first step passes. Without rounding, all
// steps down to the smallest fail.
TEST(OpenGapSearchWithRows, RoundedChangeAcceptsTheFirstStep) {
  const ShootingProblem problem = goal_problem();
  RowStep step(problem);
  step.merit.cost = -1e9;
  const LineSearchResult failed = step.run();
  EXPECT_FALSE(failed.accepted);
  step.merit.rounding = 1e10;
  for (const double first_step : {1.0, 0.25}) {
    const LineSearchResult found = step.run(first_step);
    EXPECT_TRUE(found.accepted);
    EXPECT_TRUE(found.by_rounding);
    EXPECT_EQ(found.step, first_step);
  }
}

// The augmentation is part of the merit if updates determine the multipliers, and not if the sweep
// does.
TEST(OpenGapSearchWithRows, MeritHasNoAugmentation) {
  const ShootingProblem free = testing::pendulum_swing_up();
  const ShootingProblem problem =
      testing::with_constraints(free, {testing::goal_constraint(free, {M_PI, 0})});
  const auto start = [&](const char* solver) {
    return solve(problem, solver, {.max_iterations = 1}, problem.create_trajectory()).log.at(0);
  };
  const IterationRecord by_sweep = start("intro"), by_updates = start("altro");
  EXPECT_DOUBLE_EQ(by_sweep.merit, by_sweep.cost);
  EXPECT_DOUBLE_EQ(by_sweep.constraint, M_PI);
  EXPECT_NEAR(by_updates.merit, by_updates.cost + 0.5 * by_updates.constraint_penalty * M_PI * M_PI,
              1e-9 * by_updates.merit);
}

}  // namespace
}  // namespace conddp
