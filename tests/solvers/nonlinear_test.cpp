#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/sizes.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

using testing::constant_controls;

/// Largest difference between central differences ∇_u J of the simulated cost and the reported
/// control gradient.
double gradient_error(const ShootingProblem& problem, const SolveResult& result, double h) {
  Evaluator evaluator(problem);
  Evaluation evaluation(problem);
  double worst = 0;
  for (int k = 0; k < problem.knots(); k += 7) {
    for (int i = 0; i < problem.nu(k); ++i) {
      double cost[3];
      for (int side : {0, 1}) {
        Trajectory moved = result.trajectory;
        moved.u(k)[i] += side == 0 ? -h : h;
        EXPECT_EQ(evaluator.simulate(moved), -1);
        evaluator.evaluate(moved, evaluation);
        cost[side] = evaluation.cost.sum();
      }
      const double numeric = (cost[1] - cost[0]) / (2 * h);
      worst = std::max(worst, std::abs(numeric - result.control_gradient[k][i]));
    }
  }
  return worst;
}

TEST(Nonlinear, AllSixAgreeWithoutActiveBounds) {
  const struct {
    const char* name;
    ShootingProblem problem;
    double u;
  } cases[] = {{"unicycle", testing::unicycle_parking(), 0.01},
               {"quadrotor", testing::quadrotor_move(), 1.22625},
               {"acrobot", testing::acrobot_swing_up(), 0},
               {"landing", testing::landing(), 0}};
  for (const auto& [name, problem, u] : cases) {
    if (kSmallSizes && problem.knots() >= 100) continue;
    const double cost = solve(problem, "ddp", {}, constant_controls(problem, u)).cost;
    for (const SolverInfo& solver : solvers()) {
      const SolveResult result = solve(problem, solver, {}, constant_controls(problem, u));
      EXPECT_EQ(result.status, SolveStatus::converged)
          << name << ' ' << solver.name << ": " << result.message;
      // Interior points may end in another swing-up of the acrobot.
      if (solver.name == "ipddp" && std::string_view(name) == "acrobot") continue;
      EXPECT_NEAR(result.cost, cost, 1e-6 * cost) << name << ' ' << solver.name;
    }
  }
}

TEST(Nonlinear, BoxSolversAgreeAtBoundsAndClippingFails) {
  const ShootingProblem problem = testing::unicycle_parking(1);
  const Trajectory guess = constant_controls(problem, 0.01);
  const SolveResult ddp = solve(problem, "box_ddp", {}, guess);
  const SolveResult fddp = solve(problem, "box_fddp", {}, guess);
  const SolveResult clip = solve(problem, "ilqr_clip", {.max_iterations = 200}, guess);
  EXPECT_EQ(ddp.status, SolveStatus::converged) << ddp.message;
  EXPECT_EQ(fddp.status, SolveStatus::converged) << fddp.message;
  EXPECT_NEAR(ddp.cost, fddp.cost, 1e-8 * ddp.cost);
  EXPECT_NE(clip.status, SolveStatus::converged);
  EXPECT_GT(clip.cost, ddp.cost * (1 + 1e-6));
  EXPECT_GT(clip.residuals.stationarity, 1e-3);
}

TEST(Nonlinear, BoxSolversAgreeOnWeakLegLanding) {
  const ShootingProblem problem = testing::landing(40);
  const Trajectory guess = constant_controls(problem, 0);
  const SolveResult ddp = solve(problem, "box_ddp", {}, guess);
  const SolveResult fddp = solve(problem, "box_fddp", {}, guess);
  EXPECT_EQ(ddp.status, SolveStatus::converged) << ddp.message;
  EXPECT_EQ(fddp.status, SolveStatus::converged) << fddp.message;
  EXPECT_NEAR(ddp.cost, fddp.cost, 1e-8 * ddp.cost);
  EXPECT_GT(ddp.cost, solve(testing::landing(), "ddp", {}, guess).cost * (1 + 1e-3));
  double largest = 0;
  for (int k = 0; k < problem.knots(); ++k)
    if (problem.nu(k) > 0)
      largest = std::max(largest, ddp.trajectory.u(k).lpNorm<Eigen::Infinity>());
  EXPECT_EQ(largest, 40);
}

TEST(Nonlinear, GuessControlGradientMatchesSimulatedCost) {
  const ShootingProblem problem = testing::quadrotor_move(0.5, 2);
  const SolveResult result =
      solve(problem, "box_ddp", {.max_iterations = 0}, constant_controls(problem, 1.22625));
  EXPECT_LE(gradient_error(problem, result, 1e-5), 1e-6);
  EXPECT_GT(result.residuals.stationarity, 1e-4);
}

TEST(Nonlinear, SolutionControlGradientMatchesSimulatedCost) {
  const ShootingProblem problem = testing::quadrotor_move(0.5, 2);
  const SolveResult result = solve(problem, "box_ddp", {.tolerances = {.stationarity = 1e-9}},
                                   constant_controls(problem, 1.22625));
  ASSERT_EQ(result.status, SolveStatus::converged);
  double largest = 0;
  for (const Eigen::VectorXd& g : result.control_gradient)
    largest = std::max(largest, g.lpNorm<Eigen::Infinity>());
  EXPECT_GT(largest, 1e-6) << "no bound has a multiplier";
  EXPECT_LE(gradient_error(problem, result, 1e-5), 1e-6);
}

TEST(Nonlinear, TheSixConvergeOnCartpoleSwingUp) {
  for (const double limit :
       kSmallSizes ? std::vector{3.0} : std::vector{testing::kFree, 10.0, 3.0}) {
    const ShootingProblem problem = testing::cartpole_swing_up(limit);
    for (const SolverInfo& solver : solvers()) {
      if (unsupported(solver, problem) || solver.control_bounds == BoundSupport::clipped) continue;
      const SolveResult result = solve(problem, solver, {}, constant_controls(problem, 0.01));
      EXPECT_EQ(result.status, SolveStatus::converged)
          << solver.name << " limit " << limit << ": " << result.message;
      EXPECT_EQ(result.residuals.constraint, 0);
      EXPECT_LT(result.cost, 1.5);
    }
  }
}

TEST(Nonlinear, ExactHessiansConvergeQuadratically) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  SolverOptions options;
  options.tolerances.stationarity = 1e-10;
  const SolveResult result = solve(problem, "ddp", options, constant_controls(problem, 0.01));
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const auto& log = result.log;
  const std::size_t n = log.size();
  ASSERT_GE(n, 3u);
  // Down to rounding.
  EXPECT_LE(log[n - 1].stationarity, 1e-11 + 100 * std::pow(log[n - 2].stationarity, 1.7));
}

TEST(Nonlinear, AutomaticUsesExactHessiansOnlyIfNeeded) {
  const ShootingProblem slow = testing::cartpole_swing_up(10);
  const SolveResult cartpole = solve(slow, "box_fddp", {}, constant_controls(slow, 0.01));
  EXPECT_TRUE(cartpole.log.back().exact_hessian);
  EXPECT_FALSE(cartpole.log[5].exact_hessian);
  const ShootingProblem fast = testing::quadrotor_move();
  const SolveResult quadrotor = solve(fast, "box_fddp", {}, constant_controls(fast, 1.22625));
  for (const IterationRecord& row : quadrotor.log) EXPECT_FALSE(row.exact_hessian);
}

// Pitfall 17.
TEST(Nonlinear, ThreadsChangeNoBit) {
  const struct {
    const char* name;
    ShootingProblem problem;
    double control;
  } cases[] = {{"quadrotor", testing::quadrotor_move(), 1.22625},
               {"quadrotor, limited", testing::quadrotor_move(0.5, 2), 1.22625},
               {"cartpole, limited", testing::cartpole_swing_up(3), 0.01},
               {"landing, limited", testing::landing(60), 0.01}};
  for (const auto& [name, problem, control] : cases) {
    const Trajectory guess = constant_controls(problem, control);
    for (const char* solver : {"ilqr_clip", "box_ddp", "fddp", "box_fddp"}) {
      if (unsupported(*find_solver(solver), problem)) continue;
      const auto run = [&](int threads) {
        return solve(problem, solver, {.max_iterations = 60, .threads = threads}, guess);
      };
      const SolveResult one = run(1), two = run(2);
      EXPECT_GE(one.iterations, 3) << name << ", " << solver;
      EXPECT_EQ(one.message, two.message) << name << ", " << solver;
      ASSERT_EQ(one.log.size(), two.log.size()) << name << ", " << solver;
      for (std::size_t i = 0; i < one.log.size(); ++i) {
        const IterationRecord &a = one.log[i], &b = two.log[i];
        EXPECT_TRUE(a.cost == b.cost && a.merit == b.merit && a.stationarity == b.stationarity &&
                    a.gap == b.gap && a.sweeps == b.sweeps && a.trials == b.trials &&
                    a.clamped_controls == b.clamped_controls &&
                    a.active_set_changes == b.active_set_changes)
            << name << ", " << solver << ", iteration " << i;
      }
      for (int k = 0; k < problem.knots(); ++k) {
        EXPECT_TRUE(one.trajectory.u(k) == two.trajectory.u(k)) << name << ", " << solver;
        EXPECT_TRUE(one.trajectory.x(k + 1) == two.trajectory.x(k + 1)) << name << ", " << solver;
        EXPECT_TRUE(one.feedback.K[k] == two.feedback.K[k]) << name << ", " << solver;
        EXPECT_TRUE(one.feedback.k[k] == two.feedback.k[k]) << name << ", " << solver;
      }
    }
  }
}

TEST(Nonlinear, WarmStartFromTheAnswerConvergesAtOnce) {
  const ShootingProblem problem = testing::unicycle_parking(1);
  for (const char* name : {"box_ddp", "box_fddp"}) {
    // Nonzero gradients differ along different policies.
    const SolveResult first = solve(problem, name, {.tolerances = {.stationarity = 1e-7}},
                                    constant_controls(problem, 0.01));
    const SolveResult again = solve(problem, name, {}, first.trajectory);
    EXPECT_EQ(again.status, SolveStatus::converged);
    EXPECT_EQ(again.iterations, 0);
  }
}

TEST(Nonlinear, FirstRegularizationLeadsToTheSameOptimum) {
  const ShootingProblem problem = testing::acrobot_swing_up();
  for (const char* name : {"ilqr", "ddp", "fddp"}) {
    SolverOptions options;
    const Trajectory guess = constant_controls(problem, 0);
    const double cost = solve(problem, name, options, guess).cost;
    options.regularization.initial = 1;
    const SolveResult result = solve(problem, name, options, guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
    EXPECT_GT(result.log.at(1).regularization, 0) << name;
    EXPECT_NEAR(result.cost, cost, 1e-6 * cost) << name;
  }
}

}  // namespace
}  // namespace conddp
