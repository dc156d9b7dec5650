#include "solvers/globalization/equality_search.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "solvers/constraints/augmented_lagrangian.hpp"
#include "solvers/riccati/null_space_stage.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// An iterate with open gaps, multipliers, and a step that satisfies the linear equations.
struct EqualityIterate {
  explicit EqualityIterate(const ShootingProblem& problem)
      : bounds(problem),
        evaluator(problem),
        linearization(problem),
        gaps(problem),
        trajectory(testing::random_guess(problem, 3, 0.3)),
        lagrangian(problem, {}, MultiplierSchedule::by_the_sweep),
        stages(problem),
        sweep(problem, bounds),
        feedback(problem),
        step(problem, bounds),
        search(problem) {
    lagrangian.start(Eigen::VectorXd::LinSpaced(problem.constraint_rows(), -1, 2));
    evaluator.differentiate(trajectory, linearization, &lagrangian.augmentation());
    lagrangian.measure(linearization.constraint);
    gaps.set(linearization, true);
    EXPECT_EQ(sweep.run(linearization, trajectory, gaps, {}, stages, feedback), -1);
    step.run(linearization, trajectory, gaps, feedback, false);
    merit.cost = linearization.total_cost();
    merit.gap_norm = search.infeasibility(linearization.gap, linearization.constraint);
    search.measure(linearization, trajectory, lagrangian.augmentation(), lagrangian.multipliers(),
                   step, step.curvature(linearization), merit);
  }
  double merit_of(const Trajectory& trial) {
    Evaluation evaluation(evaluator.problem());
    evaluator.evaluate(trial, evaluation);
    return evaluation.cost.sum() +
           merit.penalty * search.infeasibility(evaluation.gap, evaluation.constraint);
  }
  ControlBounds bounds;
  Evaluator evaluator;
  Linearization linearization;
  Gaps gaps;
  Trajectory trajectory;
  AugmentedLagrangian lagrangian;
  NullSpaceStage stages;
  BackwardSweep sweep;
  Feedback feedback;
  LinearRollout step;
  EqualitySearch search;
  MeritModel merit;
};

ShootingProblem goal_problem() {
  const ShootingProblem swing = testing::cartpole_swing_up();
  return testing::with_constraints(swing, {testing::goal_constraint(swing, {0, M_PI, 0, 0})});
}

TEST(EqualitySearch, MeritSlopeIsItsDerivativeAlongTheStep) {
  const ShootingProblem problem = goal_problem();
  EqualityIterate iterate(problem);
  EXPECT_NEAR(iterate.merit_of(iterate.trajectory), iterate.merit.value(),
              1e-12 * iterate.merit.value());
  EXPECT_LT(iterate.merit.merit_slope(), 0);
  const double length = 1e-6;
  Trajectory moved = iterate.trajectory;
  for (int k = 0; k <= problem.knots(); ++k) {
    const Eigen::VectorXd dx = length * iterate.step.dx(k);
    problem.manifold().integrate(iterate.trajectory.x(k).data(), dx.data(), moved.x(k).data());
    if (k < problem.knots()) moved.u(k) += length * iterate.step.du(k);
  }
  EXPECT_NEAR((iterate.merit_of(moved) - iterate.merit.value()) / length,
              iterate.merit.merit_slope(), 1e-3 * std::abs(iterate.merit.merit_slope()));
}

/// Rows of two knots and of the end; the middle rows are free.
TEST(EqualitySearch, InfeasibilitySumsGapsAndActiveRows) {
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
  EqualitySearch search(problem);
  Eigen::MatrixXd gap = Eigen::MatrixXd::Zero(2, N);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(problem.constraint_rows());
  gap(0, 0) = -2;
  gap(1, N - 1) = 3;
  EXPECT_EQ(search.infeasibility(gap, values), 5);
  for (const NodeConstraint& c : problem.constraints())
    for (int r = 0; r < 2; ++r) {
      values[c.row + r] = c.lower[r] - 7;
      if (c.node == 3) values[c.row + r] = 11;
      EXPECT_EQ(search.infeasibility(gap, values), c.node == 3 ? 5 : 12) << c.node << ' ' << r;
      values[c.row + r] = 0;
    }
}

// Equation 18.36 of Nocedal and Wright, with 0.7 of the penalty for the step.
TEST(EqualitySearch, PenaltyCoversModelStepAndHalvesAtMost) {
  const ShootingProblem problem = goal_problem();
  EqualityIterate iterate(problem);
  const Eigen::VectorXd& off = iterate.linearization.constraint;  // bounds are zero
  const Eigen::VectorXd &nu = iterate.lagrangian.multipliers(),
                        &rho = iterate.lagrangian.augmentation().penalty;
  const double slope = iterate.step.slope() + nu.dot(off);
  const double penalized = rho.dot(off.cwiseAbs2());
  EXPECT_GT(std::abs(nu.dot(off)), 1e-3);
  EXPECT_GT(penalized, 1e-3);
  const auto measured = [&](double curvature, double former, double gap_norm) {
    MeritModel merit{.cost = iterate.merit.cost, .gap_norm = gap_norm, .penalty = former};
    iterate.search.measure(iterate.linearization, iterate.trajectory,
                           iterate.lagrangian.augmentation(), nu, iterate.step, curvature, merit);
    EXPECT_NEAR(merit.slope, slope, 1e-12 * std::abs(slope));
    double states = 0;
    for (int k = 1; k <= problem.knots(); ++k)
      states += iterate.trajectory.x(k).lpNorm<Eigen::Infinity>();
    EXPECT_NEAR(merit.rounding,
                std::numeric_limits<double>::epsilon() *
                    (iterate.linearization.cost.lpNorm<1>() + merit.penalty * states),
                1e-12 * merit.rounding);
    return merit.penalty;
  };
  const double curvature = 1e4 + penalized - 2 * slope;  // slope + ½ (· − penalized) is 5000
  EXPECT_NEAR(measured(curvature, 0, 2), 5e3 / (0.7 * 2), 1e-8);
  EXPECT_NEAR(measured(curvature, 9e3, 2), 4.5e3, 1e-12);
  EXPECT_NEAR(measured(curvature, 9e3, 0), 4.5e3, 1e-12) << "nothing is left to pay for";
  // Negative curvature does not reduce the penalty.
  EXPECT_NEAR(measured(penalized - 1e9, 0, 2), std::max(0.0, slope / 1.4), 1e-9);
}

TEST(EqualitySearch, TakesTheTrialWithTheLowerMerit) {
  const ShootingProblem problem = goal_problem();
  EqualityIterate iterate(problem);
  Trajectory trajectory = iterate.trajectory;
  const LineSearchResult found =
      iterate.search.run(iterate.evaluator, iterate.merit, iterate.linearization, iterate.step,
                         iterate.feedback, 1, trajectory);
  ASSERT_TRUE(found.accepted);
  EXPECT_NEAR(iterate.merit.value() - iterate.merit_of(trajectory), found.actual_decrease,
              1e-9 * iterate.merit.value());
  double steps[kLaneWidth];
  for (double& step : steps) step = found.step;
  LaneRollout lanes(problem);
  iterate.evaluator.roll_out(iterate.trajectory, iterate.linearization.gap, iterate.feedback, steps,
                             {.contract_gaps = true}, lanes);
  Trajectory rolled = problem.create_trajectory();
  lanes.extract(0, rolled);
  // A non-finite rollout is not better either.
  EXPECT_FALSE(iterate.merit_of(rolled) < iterate.merit_of(trajectory));
}

// No rollout stays finite.
TEST(EqualitySearch, TakesTheStraightStepIfRolloutsDiverge) {
  const ShootingProblem problem = goal_problem();
  EqualityIterate iterate(problem);
  Feedback wild = iterate.feedback;
  wild.k[0].setConstant(1e300);
  Trajectory trajectory = iterate.trajectory;
  const LineSearchResult found = iterate.search.run(
      iterate.evaluator, iterate.merit, iterate.linearization, iterate.step, wild, 1, trajectory);
  ASSERT_TRUE(found.accepted);
  for (int k = 0; k <= problem.knots(); ++k) {
    const Eigen::VectorXd dx = iterate.trajectory.x(k) + found.step * iterate.step.dx(k);
    EXPECT_LT((trajectory.x(k) - dx).norm(), 1e-12 * (1 + dx.norm())) << k;
    if (k == problem.knots()) continue;
    const Eigen::VectorXd u = iterate.trajectory.u(k) + found.step * iterate.step.du(k);
    EXPECT_LT((trajectory.u(k) - u).norm(), 1e-12 * (1 + u.norm())) << k;
  }
}

// Shorter steps diverge later.
TEST(EqualitySearch, ReportsWhereTheLongestStepDiverges) {
  const ShootingProblem problem = goal_problem();
  EqualityIterate iterate(problem);
  Trajectory trajectory = iterate.trajectory;
  trajectory.u(problem.knots() - 1).setConstant(1e300);  // straight steps diverge too
  Feedback wild = iterate.feedback;
  LaneRollout lanes(problem);
  double steps[kLaneWidth];
  for (int lane = 0; lane < kLaneWidth; ++lane) steps[lane] = std::ldexp(1.0, -lane);
  for (double push = 1; push < 1e170; push *= 2) {
    wild.k[0].setConstant(push);
    iterate.evaluator.roll_out(trajectory, iterate.linearization.gap, wild, steps,
                               {.contract_gaps = true}, lanes);
    if (lanes.first_bad_knot[0] == 0) break;
  }
  ASSERT_EQ(lanes.first_bad_knot[0], 0);
  ASSERT_GT(lanes.first_bad_knot[1], 0);
  const LineSearchResult found = iterate.search.run(
      iterate.evaluator, iterate.merit, iterate.linearization, iterate.step, wild, 1, trajectory);
  EXPECT_FALSE(found.accepted);
  EXPECT_EQ(found.first_bad_knot, 0);
}

// Uphill from −10⁹, hidden by the merit's rounding: only the first step passes.
TEST(EqualitySearch, RoundedChangeAcceptsFirstStepOnly) {
  const ShootingProblem problem = goal_problem();
  EqualityIterate iterate(problem);
  MeritModel merit = iterate.merit;
  const auto run = [&](double first_step, Trajectory& trajectory) {
    return iterate.search.run(iterate.evaluator, merit, iterate.linearization, iterate.step,
                              iterate.feedback, first_step, trajectory);
  };
  merit.cost = -1e9;
  merit.rounding = 1e10;
  for (const double first_step : {1.0, 0.25}) {
    Trajectory trajectory = iterate.trajectory;
    const LineSearchResult found = run(first_step, trajectory);
    EXPECT_TRUE(found.accepted);
    EXPECT_TRUE(found.by_rounding);
    EXPECT_EQ(found.step, first_step);
    EXPECT_EQ(found.trials, 1);
  }
}

// Nothing lowers a merit of −10⁹: all steps down to the smallest are tried.
TEST(EqualitySearch, TriesAllStepsDownToTheSmallest) {
  const ShootingProblem problem = goal_problem();
  EqualityIterate iterate(problem);
  MeritModel merit = iterate.merit;
  merit.cost = -1e9;
  for (const auto& [first, trials] :
       {std::pair{1.0, 14}, {0.5, 13}, {2 * kLeastStep, 2}, {kLeastStep, 1}}) {
    Trajectory trajectory = iterate.trajectory;
    const LineSearchResult found =
        iterate.search.run(iterate.evaluator, merit, iterate.linearization, iterate.step,
                           iterate.feedback, first, trajectory);
    EXPECT_FALSE(found.accepted);
    EXPECT_EQ(found.trials, trials) << first;
    EXPECT_EQ(trajectory.u(0), iterate.trajectory.u(0));
  }
}

// The augmentation is part of the merit if updates determine the multipliers, and not if the sweep
// does.
TEST(EqualitySearch, OwnMeritHasNoAugmentation) {
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
