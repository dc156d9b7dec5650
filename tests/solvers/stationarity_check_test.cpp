#include "solvers/iterate/stationarity_check.hpp"

#include <gtest/gtest.h>

#include "support/constrained_problems.hpp"

namespace conddp::testing {
namespace {

/// x⁺ = x + u from 1, with costs ½ x² and ½ u² at each knot and ½ x² at the end.
ShootingProblem sum_of_controls(int knots) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  return tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)), Integrator::discrete,
                          knots, 1, {1}, {{0}, {1}, {1}, {1}, false});
}

/// A check of an iterate of that problem.
struct Checked {
  Checked(ShootingProblem given, bool constrained)
      : problem(std::move(given)),
        bounds(problem),
        evaluator(problem),
        record(problem, options, constrained),
        iterate(problem, bounds, evaluator, recipe, options, record),
        check(problem, bounds, options, constrained) {
    iterate.trajectory = problem.create_trajectory();
    evaluator.simulate(iterate.trajectory);
    evaluator.differentiate(iterate.trajectory, iterate.linearization);
    check.reset();
  }

  SolverOptions options;
  DdpRecipe recipe;
  ShootingProblem problem;
  ControlBounds bounds;
  Evaluator evaluator;
  SolveRecord record;
  Iterate iterate;
  StationarityCheck check;
};

/// Two knots with gradients ∇_u L = (0, s) along the gain K of the second, and (−K s, s) without
/// it.
struct HiddenByGains : Checked {
  HiddenByGains(double s, double K) : Checked(sum_of_controls(2), false) {
    auto& knots = iterate.linearization.knots;
    knots[0].gradient << 0, -K * s;
    knots[1].gradient << 0, s;
    knots[2].gradient << 0;
    Feedback feedback(problem);
    feedback.K[1](0, 0) = K;
    iterate.adjoint.compute(iterate.linearization, iterate.trajectory, iterate.gaps, feedback);
    EXPECT_DOUBLE_EQ(iterate.stationarity().value, s);
  }
};

TEST(StationarityCheck, GoalIsToleranceUntilGainsHideErrors) {
  HiddenByGains at(4e-7, 2);  // 8e-7 without gains
  EXPECT_EQ(at.check.goal(), 1e-6);
  EXPECT_TRUE(at.check.confirm(at.iterate, nullptr));
  EXPECT_EQ(at.check.goal(), 1e-6);
  HiddenByGains more(4e-7, 3);
  EXPECT_FALSE(more.check.confirm(more.iterate, nullptr));
}

// 4e-6 without gains is four times the tolerance; half of a fourth of 4e-7 should suffice.
TEST(StationarityCheck, GoalBecomesHalfOfTheRequiredGradient) {
  HiddenByGains at(4e-7, 10);
  EXPECT_FALSE(at.check.confirm(at.iterate, nullptr));
  EXPECT_NEAR(at.check.goal(), 5e-8, 1e-20);
  at.check.reset();
  EXPECT_EQ(at.check.goal(), 1e-6);
}

TEST(StationarityCheck, AmplifyingMotionsAreInconclusive) {
  HiddenByGains hidden(1e-7, 4.9e4), amplified(1e-7, 5.1e4);
  EXPECT_FALSE(hidden.check.confirm(hidden.iterate, nullptr));
  EXPECT_NEAR(hidden.check.goal(), 0.5e-6 / 4.9e4, 1e-20);
  EXPECT_TRUE(amplified.check.confirm(amplified.iterate, nullptr));
  EXPECT_EQ(amplified.check.goal(), 1e-6);
}

/// λ_0 is K s along the only gain and 0 without it; gradients are equal.
struct CarriedAway : Checked {
  explicit CarriedAway(double K) : Checked(sum_of_controls(1), false) {
    iterate.linearization.knots[0].gradient << 0, 4e-7;
    iterate.linearization.knots[1].gradient << 0;
    Feedback feedback(problem);
    feedback.K[0](0, 0) = K;
    iterate.adjoint.compute(iterate.linearization, iterate.trajectory, iterate.gaps, feedback);
  }
};

TEST(StationarityCheck, CostatesLostToGainsTightenTheGoal) {
  CarriedAway near(1200), far(2500);  // 4.8e-4, 1e-3; limit 5e-4
  EXPECT_TRUE(near.check.confirm(near.iterate, nullptr));
  EXPECT_EQ(near.check.goal(), 1e-6);
  EXPECT_FALSE(far.check.confirm(far.iterate, nullptr));
  EXPECT_NEAR(far.check.goal(), 1e-7, 1e-20);
}

TEST(StationarityCheck, ChoosesBetterCostatesIfTheyDiffer) {
  CarriedAway near(1200), far(2500);
  EXPECT_EQ(near.check.better(near.iterate, nullptr), nullptr);
  const Adjoint* better = far.check.better(far.iterate, nullptr);
  ASSERT_NE(better, nullptr);
  EXPECT_EQ(better->costates()(0, 0), 0);
  HiddenByGains hidden(4e-7, 1e4);  // 4e-3 without gains
  EXPECT_EQ(hidden.check.better(hidden.iterate, nullptr), nullptr);
}

/// One knot with a terminal constraint: x = (1, 1), u = 0, ∇_u L = 1 + ν for any gains.
struct ConstrainedEnd : Checked {
  ConstrainedEnd()
      : Checked(with_constraints(sum_of_controls(1), {goal_constraint(sum_of_controls(1), {1})}),
                true) {
    iterate.linearization.knots[0].gradient << 1, 0;
    iterate.linearization.knots[1].gradient << 4e-7;  // of the augmented Lagrangian
    iterate.adjoint.compute(iterate.linearization, iterate.trajectory, iterate.gaps,
                            Feedback(problem));
    EXPECT_DOUBLE_EQ(iterate.stationarity().value, 4e-7);
  }
  bool confirm(double nu) {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(problem.constraint_rows());
    all[all.size() - 1] = nu;
    return check.confirm(iterate, &all);
  }
};

TEST(StationarityCheck, ConstrainedMultipliersUseCostGains) {
  ConstrainedEnd at;
  EXPECT_TRUE(at.confirm(-1 + 0.9e-6));
  EXPECT_FALSE(at.confirm(-1 + 4e-6));
  EXPECT_NEAR(at.check.goal(), 5e-8, 1e-16);
}

/// With weights of 1e-7, cost derivatives are below a tolerance of 1e-6.
TEST(StationarityCheck, ConstrainedGoalFollowsLargestCostDerivative) {
  const auto small = [] {
    const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
    return tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)), Integrator::discrete,
                            1, 1, {1}, {{0}, {0}, {1e-7}, {0}, false});
  };
  Checked at(with_constraints(small(), {goal_constraint(small(), {3})}), true);
  at.iterate.trajectory.u(0)[0] = 2;  // the cost's derivative is 2e-7
  at.evaluator.simulate(at.iterate.trajectory);
  at.evaluator.differentiate(at.iterate.trajectory, at.iterate.linearization);
  const auto confirm = [&](double off) {
    at.check.reset();
    at.iterate.linearization.knots[0].gradient << 0, off;
    at.iterate.linearization.knots[1].gradient << 0;
    at.iterate.adjoint.compute(at.iterate.linearization, at.iterate.trajectory, at.iterate.gaps,
                               Feedback(at.problem));
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(at.problem.constraint_rows());
    multipliers[multipliers.size() - 1] = -2e-7 + off;
    return at.check.confirm(at.iterate, &multipliers);
  };
  EXPECT_TRUE(confirm(1.9e-9));
  EXPECT_FALSE(confirm(4e-9));
  EXPECT_NEAR(at.check.goal(), 0.5 * 2e-9, 1e-15);
}

TEST(StationarityCheck, LargeRemainingGainTightensTheGoal) {
  HiddenByGains at(4e-7, 2);
  EXPECT_TRUE(at.check.confirm_gain(at.iterate, 1e-4));
  EXPECT_EQ(at.check.goal(), 1e-6);
  EXPECT_FALSE(at.check.confirm_gain(at.iterate, 16e-4));
  EXPECT_NEAR(at.check.goal(), 0.5 * 4e-7 / 4, 1e-20);
  EXPECT_FALSE(at.check.confirm_gain(at.iterate, 1e12));
  EXPECT_DOUBLE_EQ(at.check.goal(), 1e-11);
  EXPECT_FALSE(at.check.confirm_gain(at.iterate, 2e-3)) << "that is the least goal";
  EXPECT_DOUBLE_EQ(at.check.goal(), 1e-11);
  EXPECT_TRUE(at.check.confirm_gain(at.iterate, 1e-3));
}

// 1 with zero multiplier would require 2e-13; the minimum goal is 1e-5 of the tolerance, and
// reaching it suffices.
TEST(StationarityCheck, GoalHasALowerLimit) {
  ConstrainedEnd at;
  EXPECT_FALSE(at.confirm(0));
  EXPECT_DOUBLE_EQ(at.check.goal(), 1e-11);
  EXPECT_TRUE(at.confirm(0));
}

}  // namespace
}  // namespace conddp::testing
