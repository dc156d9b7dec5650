#include "solvers/iterate/hessian_switch.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/constrained_problems.hpp"

namespace conddp {
namespace {

constexpr double kTolerance = 1e-6;

/// A solve that monitors its convergence at constant cost.
struct Watched {
  Watched() : problem(testing::quadrotor_move()), evaluator(problem), linearization(problem) {
    choice.reset();
    choice.watch(row);
  }
  /// Runs at most `most` iterations that multiply the stationarity by `factor`, until the wanted
  /// set changes. Returns their number.
  int until_change(double factor, int most = 1000) {
    const bool before = choice.exact_wanted();
    for (int i = 1; i <= most; ++i) {
      ++row.iteration;
      row.stationarity *= factor;
      choice.watch(row);
      if (choice.exact_wanted() != before) return i;
    }
    return most;
  }
  ShootingProblem problem;
  Evaluator evaluator;
  Linearization linearization;
  HessianSwitch choice{HessianUse::when_slow, kTolerance, evaluator, linearization};
  IterationRecord row{.cost = 1, .stationarity = 1};
};

TEST(HessianSwitch, KeepsGaussNewtonWhileItConverges) {
  Watched solve;
  EXPECT_EQ(solve.until_change(0.8, 60), 60);
}

TEST(HessianSwitch, GivesUpSlowSetsAndExtendsGaussNewton) {
  Watched solve;
  const int first = solve.until_change(1);
  EXPECT_TRUE(solve.choice.exact_wanted());
  const int exact = solve.until_change(1);
  EXPECT_FALSE(solve.choice.exact_wanted());
  EXPECT_EQ(solve.until_change(1), 2 * first);
  EXPECT_EQ(solve.until_change(1), exact);
  EXPECT_EQ(solve.until_change(1), 4 * first);
}

TEST(HessianSwitch, KeepsExactHessiansOnSufficientRate) {
  Watched solve;
  const int window = [] {
    Watched other;
    other.until_change(1);
    return other.until_change(1);
  }();
  solve.until_change(1);
  // Four decades of six: two remain, fewer than were covered.
  EXPECT_EQ(solve.until_change(std::pow(10.0, -4.0 / window), window), window);
  EXPECT_TRUE(solve.choice.exact_wanted());
}

// An exact Hessian of 12 states and 4 controls costs as much as 17 iterations. The windows are ten
// Gauss-Newton iterations, and as many exact ones as cost a thousand.
TEST(HessianSwitch, WindowsFollowTheCostOfAnIteration) {
  Watched solve;
  EXPECT_EQ(solve.until_change(1), 10);
  EXPECT_EQ(solve.until_change(1), 1000 / 17);
}

// At d decades per iteration, 6 − 10 d remain, where four exact iterations cost as much as 4 · 17.
TEST(HessianSwitch, GaussNewtonIsSlowBeyondFourExactIterations) {
  constexpr double kDecades = 6.0 / (10 + 4 * 17);
  Watched slow, quick;
  EXPECT_EQ(slow.until_change(std::pow(10, -0.99 * kDecades)), 10);
  EXPECT_EQ(quick.until_change(std::pow(10, -1.01 * kDecades), 30), 30);
  EXPECT_FALSE(quick.choice.exact_wanted());
}

TEST(HessianSwitch, GaussNewtonIsNotSlowWhileCostFalls) {
  for (const double cost : {0.905, 0.915}) {  // 1 is 1.1 times 0.909
    Watched solve;
    solve.row.cost = cost;
    solve.until_change(1, 10);
    EXPECT_EQ(solve.choice.exact_wanted(), cost > 0.91) << cost;
  }
}

// Half of six decades within a window.
TEST(HessianSwitch, ExactHessiansAreSlowIfMostIsLeft) {
  for (const double decades : {2.95, 3.05}) {
    Watched solve;
    ASSERT_EQ(solve.until_change(1), 10);
    solve.until_change(std::pow(10, -decades / 58), 58);
    EXPECT_EQ(solve.choice.exact_wanted(), decades > 3) << decades;
  }
}

TEST(HessianSwitch, KeepsExactHessiansRequestedByRounding) {
  Watched solve;
  EXPECT_TRUE(solve.choice.turn());
  EXPECT_EQ(solve.until_change(1, 500), 500);
  EXPECT_FALSE(solve.choice.turn());
}

/// True if a solve detects equal Hessians after exact ones are requested.
bool finds_the_same(const ShootingProblem& problem) {
  Evaluator evaluator(problem);
  Linearization linearization(problem);
  HessianSwitch choice(HessianUse::when_slow, kTolerance, evaluator, linearization);
  choice.reset();
  choice.turn();
  const Trajectory trajectory = testing::random_guess(problem, 3);
  choice.begin_iterate();
  evaluator.differentiate(trajectory, linearization);
  std::vector<Eigen::MatrixXd> before;
  for (const KnotLinearization& knot : linearization.knots) before.push_back(knot.hessian());
  choice.evaluate_exact(trajectory, Eigen::MatrixXd::Ones(problem.ndx(), problem.knots() + 1));
  const bool same = !choice.exact_known();
  EXPECT_EQ(choice.exact_in_use(), !same);
  EXPECT_EQ(choice.exact_wanted(), !same);
  choice.use(false);
  for (int k = 0; k <= problem.knots(); ++k)
    EXPECT_EQ(linearization.knots[k].hessian(), before[k]) << k;
  return same;
}

// For linear dynamics and squares, exact Hessians equal Gauss-Newton's, for nodes of any size.
TEST(HessianSwitch, DetectsExactHessiansEqualToGaussNewton) {
  const testing::LinearQuadratic lq(1, 3, {2, 1}, 2, -1, 1);
  EXPECT_TRUE(finds_the_same(*lq.problem));
  EXPECT_FALSE(finds_the_same(testing::pendulum_swing_up()));
  // Only the norm at the last node is curved.
  const ShootingProblem curved =
      testing::with_constraints(*lq.problem, {{.name = "norm",
                                               .residual = state_residual(lq.problem->manifold()),
                                               .kind = ConstraintKind::norm,
                                               .reference = {0.1, 0.2, 0.3},
                                               .lower = {0},
                                               .upper = {0.5},
                                               .first = lq.N(),
                                               .last = lq.N()}});
  Evaluator evaluator(curved);
  Linearization linearization(curved);
  HessianSwitch choice(HessianUse::when_slow, kTolerance, evaluator, linearization);
  choice.reset();
  Augmentation augmentation(curved);
  augmentation.multiplier.setOnes();
  const Trajectory trajectory = testing::random_guess(curved, 3);
  evaluator.differentiate(trajectory, linearization, &augmentation);
  choice.evaluate_exact(trajectory, Eigen::MatrixXd::Zero(3, lq.N() + 1), &augmentation);
  EXPECT_TRUE(choice.exact_known());
}

/// The pendulum with its final angle maximized.
ShootingProblem pendulum_with_linear_cost() {
  const ShootingProblem pendulum = testing::pendulum_swing_up(2);
  const std::shared_ptr<const System>& system = pendulum.phases()[0].model->shared_system();
  auto model = std::make_shared<KnotModel>(system, Integrator::none);
  model->add_cost("angle", coordinate_residual(system->manifold(), {0}),
                  {.kind = ActivationKind::linear});
  return {pendulum.initial_state(),
          pendulum.phases(),
          {.name = "end", .model = model, .dt = {0}, .cost_scale = {1}, .parameters = {0, -1}}};
}

TEST(HessianSwitch, LinearCostsUseExactHessiansOnly) {
  const ShootingProblem squares = testing::pendulum_swing_up(2);
  const ShootingProblem linear = pendulum_with_linear_cost();
  const SolverOptions automatic;
  SolverOptions all_exact, none_exact;
  all_exact.hessian = HessianChoice::exact;
  none_exact.hessian = HessianChoice::gauss_newton;
  using enum HessianUse;
  EXPECT_EQ(hessian_use(when_slow, automatic, squares), when_slow);
  EXPECT_EQ(hessian_use(when_slow, all_exact, squares), exact);
  EXPECT_EQ(hessian_use(when_slow, none_exact, squares), gauss_newton);
  EXPECT_EQ(hessian_use(exact, automatic, squares), exact);
  EXPECT_EQ(hessian_use(when_slow, automatic, linear), exact_alone);
  EXPECT_EQ(hessian_use(when_slow, all_exact, linear), exact_alone);
  EXPECT_EQ(hessian_use(exact, automatic, linear), exact_alone);
  EXPECT_EQ(hessian_use(when_slow, none_exact, linear), gauss_newton);
  EXPECT_EQ(hessian_use(gauss_newton, automatic, linear), gauss_newton);
}

}  // namespace
}  // namespace conddp
