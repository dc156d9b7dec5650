// Searches along a multiple of the step to the minimum of a linear-quadratic problem. The cost of
// every trial is a parabola: f(α) = f(0) − D (2 l α − l² α²).
#include "solvers/globalization/line_search.hpp"

#include <gtest/gtest.h>

#include "solvers/common/tuning.hpp"
#include "solvers/riccati/linear_rollout.hpp"
#include "support/linear_quadratic.hpp"

namespace conddp::testing {
namespace {

struct ParabolaSearch {
  /// `multiple`: length of the searched step relative to the step to the minimum.
  explicit ParabolaSearch(double multiple)
      : lq(2, 3, {2, 1}, 3, -kFree, kFree, 1),
        problem(*lq.problem),
        bounds(problem),
        evaluator(problem),
        linearization(problem),
        gaps(problem),
        trajectory(random_guess(problem, 3)),
        adjoint(problem, bounds),
        sweep(problem, bounds),
        stages(unconstrained_stage(problem)),
        feedback(problem),
        rollout(problem, bounds),
        search(problem),
        length(multiple) {
    trajectory.x(0) = lq.x0;
    EXPECT_EQ(evaluator.simulate(trajectory), -1);
    evaluator.differentiate(trajectory, linearization);
    gaps.set(linearization, false);
    EXPECT_EQ(sweep.run(linearization, trajectory, gaps, {}, *stages, feedback), -1);
    adjoint.compute(linearization, trajectory, gaps, feedback);
    rollout.run(linearization, trajectory, gaps, feedback, false);
    most = lq.cost(trajectory) - lq.cost(lq.dense_optimum());
    for (Eigen::VectorXd& k : feedback.k) k *= length;
    merit = {.cost = linearization.total_cost(), .slope = length * rollout.slope()};
  }
  LineSearchResult run(double first_step = 1) {
    Trajectory from = trajectory;
    const LineSearchResult found =
        search.run(evaluator, merit, adjoint, linearization.gap, feedback, {}, first_step, from);
    moved = from;
    return found;
  }
  double decrease(double step) const {
    const double at = length * step;
    return most * (2 * at - at * at);
  }

  LinearQuadratic lq;
  const ShootingProblem& problem;
  ControlBounds bounds;
  Evaluator evaluator;
  Linearization linearization;
  Gaps gaps;
  Trajectory trajectory;
  Adjoint adjoint;
  BackwardSweep sweep;
  std::unique_ptr<StageSolver> stages;
  Feedback feedback;
  LinearRollout rollout;
  LineSearch search;
  MeritModel merit;
  Trajectory moved;
  double most = 0;  ///< D
  double length;
};

TEST(LineSearch, TakesOnlyTheFullStepToTheMinimum) {
  ParabolaSearch at(1);
  const LineSearchResult found = at.run();
  EXPECT_TRUE(found.accepted);
  EXPECT_EQ(found.step, 1);
  EXPECT_EQ(found.trials, 1);
  EXPECT_FALSE(found.by_rounding);
  EXPECT_EQ(found.first_bad_knot, -1);
  EXPECT_NEAR(found.actual_decrease, at.most, 1e-9 * at.most);
  EXPECT_NEAR(found.expected_decrease, 2 * at.most, 1e-9 * at.most);
  EXPECT_NEAR(at.lq.cost(at.moved), at.merit.cost - at.most, 1e-9 * at.most);
}

// The search takes a step that lowers the merit, or its half if that lowers it more.
TEST(LineSearch, TakesLongestStepUnlessItsHalfIsBetter) {
  if (kLaneWidth < 4) GTEST_SKIP() << "a step is compared with its half in the lane beside it";
  struct Case {
    double length, step;
    int trials;
  };
  // f falls by D (2 l α − l² α²): for l = 1.5 by 0.75, 0.9375, 0.61; for 2 by 0, 1, 0.75; for 3 by
  // −3, 0.75, 0.94, 0.61; for 6.5 by −29, −4, 0.61, 0.97, 0.65.
  for (const Case& c :
       {Case{0.5, 1, 1}, {1.5, 0.5, 2}, {2, 0.5, 2}, {3, 0.25, 3}, {6.5, 0.125, 4}}) {
    ParabolaSearch at(c.length);
    const LineSearchResult found = at.run();
    EXPECT_TRUE(found.accepted) << c.length;
    const bool alone = c.length < 1;  // falls by at least a third of the slope
    EXPECT_EQ(found.step, alone ? 1 : c.step) << c.length;
    EXPECT_EQ(found.trials, alone ? 1 : c.trials) << c.length;
    EXPECT_NEAR(found.actual_decrease, at.decrease(found.step), 1e-9 * at.most) << c.length;
    EXPECT_NEAR(found.expected_decrease, 2 * c.length * found.step * at.most, 1e-9 * at.most)
        << c.length;
    EXPECT_NEAR(at.lq.cost(at.moved), at.merit.cost - found.actual_decrease, 1e-9 * at.most);
  }
}

TEST(LineSearch, BeginsWithTheLongestAllowedStep) {
  ParabolaSearch at(3);
  const LineSearchResult found = at.run(0.25);
  EXPECT_EQ(found.step, 0.25);
  EXPECT_EQ(found.trials, 1);
  EXPECT_NEAR(found.actual_decrease, at.decrease(0.25), 1e-9 * at.most);
}

// Below 1/8, the half of an acceptable step is not tried: for l = 13 the decrease is −143, −29, −4,
// 0.61 and, for the half, 0.97.
TEST(LineSearch, ShortStepsAreNotHalvedAgain) {
  ParabolaSearch at(13);
  const LineSearchResult found = at.run();
  EXPECT_TRUE(found.accepted);
  EXPECT_EQ(found.step, 0.125);
  EXPECT_EQ(found.trials, 4);
}

TEST(LineSearch, GivesUpBelowTheSmallestStep) {
  ParabolaSearch at(-1);
  const Trajectory before = at.trajectory;
  for (const auto& [first, trials] : {std::pair{1.0, 14},
                                      {4 * tuning::kLeastStep, 3},
                                      {tuning::kLeastStep, 1},
                                      {0.9 * tuning::kLeastStep, 0}}) {
    at.search.reset();
    const LineSearchResult found = at.run(first);
    EXPECT_FALSE(found.accepted);
    EXPECT_EQ(found.trials, trials) << first;
    for (int k = 0; k < at.lq.N(); ++k) EXPECT_EQ(at.moved.u(k), before.u(k)) << k;
  }
}

// A step of 1/8, whose half is no rival, reaches the share 1 − l / 16 of the slope.
TEST(LineSearch, RequiresItsShareOfTheSlope) {
  for (const double share : {0.5 * tuning::kArmijo, 2 * tuning::kArmijo}) {
    ParabolaSearch at(16 * (1 - share));
    const LineSearchResult found = at.run();
    EXPECT_EQ(found.step, share < tuning::kArmijo ? 1.0 / 16 : 1.0 / 8) << share;
  }
}

TEST(LineSearch, RoundedDecreaseAcceptsConstantMerit) {
  ParabolaSearch at(1);
  at.merit.rounding = at.most;
  const LineSearchResult hidden = at.run();
  EXPECT_TRUE(hidden.accepted);
  EXPECT_TRUE(hidden.by_rounding);
  EXPECT_EQ(hidden.step, 1);
  // Every step goes uphill by more: Armijo fails, and only the first step may be hidden by
  // rounding.
  ParabolaSearch up(-1);
  up.merit.rounding = 0.21 * up.most;  // hides 2.1 D: the slope, but not 3 D
  const LineSearchResult none = up.run();
  EXPECT_FALSE(none.accepted);
}

// The merit counts the closed part of gaps.
TEST(LineSearch, CountsTheGapsThatAStepCloses) {
  ParabolaSearch at(1);
  at.merit.gap_norm = 3;
  at.merit.penalty = 2;
  const LineSearchResult found = at.run();
  EXPECT_NEAR(found.actual_decrease, at.most + 6, 1e-9 * at.most);
  EXPECT_NEAR(found.expected_decrease, 2 * at.most + 6, 1e-9 * at.most);
}

TEST(LineSearch, ReportsWhereATrialDiverges) {
  ParabolaSearch at(1);
  at.feedback.k[2].setConstant(1e308);
  at.feedback.k[2] *= 10;
  const LineSearchResult found = at.run();
  EXPECT_FALSE(found.accepted);
  EXPECT_EQ(found.first_bad_knot, 2);
}

}  // namespace
}  // namespace conddp::testing
