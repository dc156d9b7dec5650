#include <gtest/gtest.h>

#include "analysis/certificate/lagrangian_gradient.hpp"
#include "analysis/comparison/benchmark.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

using testing::quadrotor_move;
using testing::tracking_problem;

/// One pendulum step, so that the gradient is the derivative of the cost with respect to the
/// control.
ShootingProblem one_step(double low = -testing::kFree, double up = testing::kFree) {
  return tracking_problem(pendulum({}), Integrator::rk4, 1, 0.1, {0.5, 0},
                          {{0, 0}, {0.2, 0.3}, {0.1}, {10, 5}}, low, up);
}

Trajectory simulated(const ShootingProblem& problem, double control) {
  Trajectory trajectory = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k) trajectory.u(k).setConstant(control);
  Evaluator(problem).simulate(trajectory);
  return trajectory;
}

double cost_of(const ShootingProblem& problem, double control) {
  return check_answer(problem, simulated(problem, control)).cost;
}

TEST(AnswerCheck, StationarityIsTheDerivativeOfTheCost) {
  const ShootingProblem problem = one_step();
  const AnswerCheck check = check_answer(problem, simulated(problem, 0.7));
  constexpr double kStep = 1e-5;
  const double slope =
      (cost_of(problem, 0.7 + kStep) - cost_of(problem, 0.7 - kStep)) / (2 * kStep);
  EXPECT_GT(std::abs(slope), 1e-2);
  EXPECT_NEAR(check.stationarity, std::abs(slope), 1e-8);
  EXPECT_EQ(check.gap, 0);
  EXPECT_EQ(check.constraint, 0);
  EXPECT_EQ(check.complementarity, 0);
}

TEST(AnswerCheck, ComputesGapsOfKnotsAndStart) {
  const ShootingProblem problem = one_step();
  Trajectory trajectory = simulated(problem, 0.7);
  trajectory.x(1)[1] += 0.25;
  EXPECT_NEAR(check_answer(problem, trajectory).gap, 0.25, 1e-14);
  trajectory = simulated(problem, 0.7);
  trajectory.x(0)[0] += 0.5;
  EXPECT_GE(check_answer(problem, trajectory).gap, 0.5);
}

/// Finite differences of the Lagrangian on a curved space with an open gap. The costate makes it
/// stationary in x_1; its derivative with respect to u remains.
TEST(AnswerCheck, OpenGapsEnterThroughTheCostate) {
  const ShootingProblem problem =
      tracking_problem(quadrotor({}), Integrator::semi_implicit_euler, 1, 0.1,
                       {0, 0, 1, 0, 0, 0, 1, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6},
                       {{2, 1, 2, 0, 0, std::sin(0.6), std::cos(0.6), 0, 0, 0, 0, 0, 0},
                        std::vector<double>(12, 0.1),
                        std::vector<double>(4, 0.01),
                        {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}});
  const StateManifold& manifold = problem.manifold();
  const int ndx = problem.ndx(), nu = problem.nu(0);
  Trajectory trajectory = simulated(problem, 2);
  Eigen::VectorXd away(ndx);
  for (int i = 0; i < ndx; ++i) away[i] = 0.3 * std::sin(i + 1);
  manifold.integrate(trajectory.x(1).data(), away.data(), trajectory.x(1).data());

  Evaluator evaluator(problem);
  Evaluation evaluation(problem);
  const auto evaluate = [&](int index, double step) {
    Trajectory moved = trajectory;
    if (index < ndx) {
      Eigen::VectorXd dx = step * Eigen::VectorXd::Unit(ndx, index);
      manifold.integrate(moved.x(1).data(), dx.data(), moved.x(1).data());
    } else {
      moved.u(0)[index - ndx] += step;
    }
    evaluator.evaluate(moved, evaluation);
    return std::pair(evaluation.cost.sum(), Eigen::VectorXd(evaluation.gap.col(0)));
  };
  constexpr double kStep = 1e-5;
  Eigen::VectorXd cost(ndx + nu);
  Eigen::MatrixXd gap(ndx, ndx + nu);
  for (int i = 0; i < ndx + nu; ++i) {
    const auto [cost_up, gap_up] = evaluate(i, kStep);
    const auto [cost_down, gap_down] = evaluate(i, -kStep);
    cost[i] = (cost_up - cost_down) / (2 * kStep);
    gap.col(i) = (gap_up - gap_down) / (2 * kStep);
  }
  const Eigen::VectorXd lambda =
      gap.leftCols(ndx).transpose().partialPivLu().solve(-cost.head(ndx));
  const Eigen::VectorXd gradient = cost.tail(nu) + gap.rightCols(nu).transpose() * lambda;
  EXPECT_GT(gradient.norm(), 0.1);
  EXPECT_NEAR(check_answer(problem, trajectory).stationarity, gradient.lpNorm<Eigen::Infinity>(),
              1e-6 * gradient.norm());
}

TEST(AnswerCheck, ActiveBoundAbsorbsTheGradient) {
  const double free_slope = check_answer(one_step(), simulated(one_step(), 3)).stationarity;
  ASSERT_GT(cost_of(one_step(), 3 + 1e-3), cost_of(one_step(), 3));  // descent leads below
  const ShootingProblem problem = one_step(3, 5);
  const AnswerCheck at = check_answer(problem, simulated(problem, 3));
  EXPECT_EQ(at.stationarity, 0);
  EXPECT_EQ(at.complementarity, 0);
  const AnswerCheck near = check_answer(problem, simulated(problem, 3 + 1e-7));
  EXPECT_EQ(near.stationarity, 0);
  EXPECT_NEAR(near.complementarity, 1e-7 * free_slope, 1e-9 * free_slope);
  EXPECT_NEAR(check_answer(problem, simulated(problem, 3 + 1e-3)).stationarity, free_slope,
              1e-2 * free_slope);
  EXPECT_NEAR(check_answer(problem, simulated(problem, 2.5)).constraint, 0.5, 1e-15);
  const ShootingProblem above = one_step(-5, 3);
  EXPECT_NEAR(check_answer(above, simulated(above, 3)).stationarity, free_slope,
              1e-12 * free_slope);
}

TEST(AnswerCheck, FixedControlMayBePushedEitherWay) {
  for (const double control : {-2.0, 0.7}) {
    ASSERT_GT(check_answer(one_step(), simulated(one_step(), control)).stationarity, 1e-2);
    const ShootingProblem fixed = one_step(control, control);
    const AnswerCheck check = check_answer(fixed, simulated(fixed, control));
    EXPECT_EQ(check.stationarity, 0) << control;
    EXPECT_EQ(check.complementarity, 0) << control;
  }
}

TEST(AnswerCheck, AnswersOfAllSolversAreStationary) {
  const ShootingProblem bounded = quadrotor_move(0, 6), swing_up = testing::pendulum_swing_up(3);
  for (const ShootingProblem* problem : {&bounded, &swing_up})
    for (const char* solver : {"box_ddp", "box_fddp"}) {
      const SolveResult result = solve(*problem, solver, {}, problem->create_trajectory());
      ASSERT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
      const AnswerCheck check = check_answer(*problem, result.trajectory);
      EXPECT_LE(check.stationarity, 1e-5) << solver;
      EXPECT_LE(check.gap, 1e-9) << solver;
      EXPECT_EQ(check.constraint, 0) << solver;
      EXPECT_NEAR(check.cost, result.cost, 1e-12 * std::abs(result.cost)) << solver;
    }
}

TEST(AnswerCheck, NonFiniteNumbersHaveNoMeasure) {
  const ShootingProblem problem = one_step();
  Trajectory trajectory = simulated(problem, 0);
  trajectory.u(0)[0] = std::numeric_limits<double>::quiet_NaN();
  const AnswerCheck check = check_answer(problem, trajectory);
  EXPECT_TRUE(std::isnan(check.cost) && std::isnan(check.gap) && std::isnan(check.stationarity) &&
              std::isnan(check.constraint) && std::isnan(check.complementarity));
}

/// Rows at three nodes of a mass, each with its own multiplier.
TEST(AnswerCheck, EveryConstraintHasItsOwnMultipliers) {
  const auto system = double_integrator(1);
  auto model = std::make_shared<KnotModel>(system, Integrator::rk4);
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  for (const auto& each : {model, end})
    each->add_constraint(
        make_constraint("box", state_residual(each->manifold()), ConstraintKind::bounds));
  // Upper bounds of 1 and 2, no lower bounds.
  const std::vector<double> box = {0, 0, -testing::kFree, -testing::kFree, 1, 2, 1};
  std::vector<double> twice = box;
  twice.insert(twice.end(), box.begin(), box.end());
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "all", .model = model, .dt = {1, 1}, .cost_scale = {1, 1}, .parameters = twice});
  const ShootingProblem problem(
      {0.5, 0}, std::move(phases),
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = box});
  const Trajectory rests = simulated(problem, 0);
  for (int row = 0; row < 6; ++row) {
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(6);
    multipliers[row] = 3;
    const AnswerCheck check = check_answer(problem, rests, kBoundRounding, multipliers);
    EXPECT_NEAR(check.complementarity, row % 2 == 0 ? 3 * 0.5 : 3 * 2, 1e-14) << row;
    EXPECT_EQ(check.constraint, 0);
  }
  Trajectory beyond = rests;
  for (int k = 0; k <= 2; ++k) {
    beyond.x(k)[1] = 2 + 0.25 * (k + 1);
    EXPECT_NEAR(check_answer(problem, beyond).constraint, 0.25 * (k + 1), 1e-14);
  }
}

TEST(AnswerCheck, ViolationsOfControlBoundsAreTheLargest) {
  const ShootingProblem problem = testing::unicycle_parking(1);
  Trajectory trajectory = problem.create_trajectory();
  trajectory.u(3)[1] = 1.25;
  EXPECT_EQ(check_answer(problem, trajectory).constraint, 0.25);
  trajectory.u(0)[0] = -1.5;
  EXPECT_EQ(check_answer(problem, trajectory).constraint, 0.5);
  trajectory.u(problem.knots() - 1)[0] = -2;
  EXPECT_EQ(check_answer(problem, trajectory).constraint, 1);
}

}  // namespace
}  // namespace conddp
