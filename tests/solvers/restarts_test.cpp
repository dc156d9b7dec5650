// Solves from several starts: the selected answer and the report of the others.
#include <atomic>
#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "solvers/strategies/strategies.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

using testing::TrackingCost;

constexpr int kStarts = 7;

ShootingProblem double_integrator_move() {
  const TrackingCost cost{.goal = {1, 0}, .q = {1, 1}, .r = {1}, .qf = {1, 1}};
  return testing::tracking_problem(double_integrator(1), Integrator::semi_implicit_euler, 4, 0.1,
                                   {0, 0}, cost);
}

SolverOptions with_restarts(int seed, int count = kStarts - 1) {
  SolverOptions options;
  options.restarts = {.count = count, .seed = seed, .spread = 0.5};
  return options;
}

/// A solve that converges with a cost given by its first control.
SolveResult ends_at(const ShootingProblem& problem, const Trajectory& start, double cost,
                    SolveStatus status = SolveStatus::converged) {
  SolveResult result(problem);
  result.trajectory = start;
  result.cost = cost;
  result.status = status;
  return result;
}

using End = std::function<SolveResult(const Trajectory&)>;

SolveResult run(const ShootingProblem& problem, const SolverOptions& options, int threads,
                const End& end) {
  const SolverInfo* used = nullptr;
  const Solve solve = [&](const Trajectory& start, const SolverOptions&, const SolverInfo*& by) {
    by = find_solver("altro");
    return end(start);
  };
  SolveResult result =
      solve_restarts(problem, options, problem.create_trajectory(), threads, solve, used);
  EXPECT_EQ(used, find_solver("altro"));
  return result;
}

/// The start whose first control is closest to a target, so that targets distinguish starts.
SolveResult nearest(const ShootingProblem& problem, const SolverOptions& options, double target,
                    int threads = 1) {
  return run(problem, options, threads, [&](const Trajectory& start) {
    return ends_at(problem, start, std::abs(start.u(0)[0] - target));
  });
}

TEST(Restarts, ReturnTheBestAnswer) {
  const ShootingProblem problem = double_integrator_move();
  for (int seed = 0; seed < 5; ++seed) {
    const SolverOptions options = with_restarts(seed);
    // The largest, the smallest, and the values closest to targets between them.
    const double up = nearest(problem, options, 100).trajectory.u(0)[0];
    const double low = nearest(problem, options, -100).trajectory.u(0)[0];
    EXPECT_GT(up, 0) << seed;
    EXPECT_LT(low, 0) << seed;
    EXPECT_EQ(nearest(problem, options, 0).trajectory.u(0)[0], 0) << "the guess, seed " << seed;
    for (const double target : {0.2, -0.2, 0.4}) {
      const double found = nearest(problem, options, target).trajectory.u(0)[0];
      EXPECT_LE(std::abs(found - target), std::abs(0 - target)) << seed;
      EXPECT_LE(std::abs(found - target), std::abs(up - target)) << seed;
      EXPECT_LE(std::abs(found - target), std::abs(low - target)) << seed;
    }
  }
}

TEST(Restarts, KeepTheInitialState) {
  const ShootingProblem problem = double_integrator_move();
  const Trajectory start = nearest(problem, with_restarts(1), 100).trajectory;
  EXPECT_EQ(start.x(0), problem.create_trajectory().x(0));
  EXPECT_NE(start.x(1), problem.create_trajectory().x(1));
  EXPECT_NE(start.u(0)[0], nearest(problem, with_restarts(4), 100).trajectory.u(0)[0]);
}

TEST(Restarts, RejectFailedStartsHoweverLowTheirCost) {
  const ShootingProblem problem = double_integrator_move();
  const SolverOptions options = with_restarts(2);
  const SolveResult result = run(problem, options, 1, [&](const Trajectory& t) {
    return t.u(0)[0] > 0 ? ends_at(problem, t, -t.u(0)[0], SolveStatus::max_iterations)
                         : ends_at(problem, t, t.u(0)[0]);
  });
  EXPECT_EQ(result.trajectory.u(0)[0], nearest(problem, options, -100).trajectory.u(0)[0]);
  EXPECT_EQ(result.restarts->starts, kStarts);
  EXPECT_LT(result.restarts->converged, kStarts);
}

TEST(Restarts, ReturnGuessAnswerIfNoneConverges) {
  const ShootingProblem problem = double_integrator_move();
  const SolveResult result = run(problem, with_restarts(2), 1, [&](const Trajectory& t) {
    return ends_at(problem, t, -std::abs(t.u(0)[0]), SolveStatus::line_search_failed);
  });
  EXPECT_EQ(result.status, SolveStatus::line_search_failed);
  EXPECT_EQ(result.restarts->answer, 0);
  EXPECT_TRUE(result.restarts->basins.empty());
}

/// A trajectory that rises to a height.
Trajectory ramp(const ShootingProblem& problem, double height) {
  Trajectory trajectory = problem.create_trajectory();
  for (int k = 0; k <= problem.knots(); ++k) trajectory.x(k)[0] = height * k / problem.knots();
  return trajectory;
}

TEST(Restarts, DistinguishOptimaByCostAndTrajectory) {
  const ShootingProblem problem = double_integrator_move();
  // Cost and height of each start.
  const std::pair<double, double> ends[] = {{2, 1},  {1 + 1e-8, 1}, {1, 1.001}, {1, -1},
                                            {2, -3}, {2, 1},        {3, 1}};
  int start = 0;
  const SolveResult result = run(problem, with_restarts(0), 1, [&](const Trajectory&) {
    const auto [cost, height] = ends[start++];
    return ends_at(problem, ramp(problem, height), cost);
  });
  // Among equal costs the first start wins, even if another is lower by rounding.
  EXPECT_EQ(result.restarts->answer, 1);
  EXPECT_EQ(result.cost, 1 + 1e-8);
  const auto& basins = result.restarts->basins;
  ASSERT_EQ(basins.size(), 5u);
  const Basin expected[] = {{1, 1, 3}, {1 + 1e-8, 2, 1}, {2, 2, 0}, {2, 1, 4}, {3, 1, 6}};
  for (std::size_t i = 0; i < basins.size(); ++i) {
    EXPECT_EQ(basins[i].cost, expected[i].cost) << i;
    EXPECT_EQ(basins[i].starts, expected[i].starts) << i;
    EXPECT_EQ(basins[i].first, expected[i].first) << i;
  }
}

// Includes the first node, which some problems choose.
TEST(Restarts, DistinguishOptimaThatDifferAtOneNode) {
  const ShootingProblem problem = double_integrator_move();
  for (int node = 0; node <= problem.knots(); ++node) {
    int start = 0;
    const SolveResult result = run(problem, with_restarts(0, 1), 1, [&](const Trajectory&) {
      Trajectory end = ramp(problem, 1);
      if (start++ == 1) end.x(node)[0] += 0.5;
      return ends_at(problem, end, 1);
    });
    EXPECT_EQ(result.restarts->basins.size(), 2u) << node;
  }
}

TEST(Restarts, StopOnTimeLimitOrSignal) {
  const ShootingProblem problem = double_integrator_move();
  const auto all = [&](const Trajectory& t) { return ends_at(problem, t, 1); };
  SolverOptions options = with_restarts(0);
  options.max_time_s = 0;
  EXPECT_EQ(run(problem, options, 1, all).restarts->starts, 1);
  options = with_restarts(0);
  int asked = 0;
  options.interrupted = [&] { return ++asked == 3; };
  EXPECT_EQ(run(problem, options, 1, all).restarts->starts, 3);
}

TEST(Restarts, PassOnSolverExceptions) {
  const ShootingProblem problem = double_integrator_move();
  for (const int threads : {1, 3})
    EXPECT_THROW(run(problem, with_restarts(0), threads,
                     [&](const Trajectory& t) -> SolveResult {
                       if (t.u(0)[0] > 0) throw std::invalid_argument("no");
                       return ends_at(problem, t, 1);
                     }),
                 std::invalid_argument);
}

class RestartedSolver : public ::testing::TestWithParam<const char*> {};

/// A swing-up; some guesses start to the left, some to the right.
struct SwingUp {
  ShootingProblem problem = testing::pendulum_swing_up(4);
  Trajectory guess = testing::constant_controls(problem, 0.1);
};

TEST_P(RestartedSolver, AnswerIsIndependentOfThreadCount) {
  const SwingUp up;
  SolverOptions options = with_restarts(3, 5);
  options.restarts.spread = 3;
  const SolveResult one = solve(up.problem, GetParam(), options, up.guess);
  options.threads = 3;
  std::atomic<int> inside = 0;
  bool alone = true;
  options.interrupted = [&] {
    alone = alone && ++inside == 1;
    --inside;
    return false;
  };
  const SolveResult three = solve(up.problem, GetParam(), options, up.guess);
  EXPECT_TRUE(alone) << "callbacks meet";
  ASSERT_EQ(one.status, SolveStatus::converged) << one.message;
  EXPECT_EQ(one.cost, three.cost);
  EXPECT_EQ(one.iterations, three.iterations);
  EXPECT_EQ(one.restarts->answer, three.restarts->answer);
  EXPECT_EQ(one.restarts->converged, three.restarts->converged);
  EXPECT_EQ(one.restarts->basins.size(), three.restarts->basins.size());
  for (int k = 0; k < up.problem.knots(); ++k)
    EXPECT_EQ(one.trajectory.u(k), three.trajectory.u(k));
}

TEST_P(RestartedSolver, BeginsWithTheSolveWithoutRestarts) {
  const SwingUp up;
  const SolveResult plain = solve(up.problem, GetParam(), {}, up.guess);
  ASSERT_EQ(plain.status, SolveStatus::converged);
  SolverOptions options = with_restarts(0, 1);
  options.restarts.spread = 1e-9;  // ends at the same optimum, so start 0 wins
  options.threads = 2;
  const SolveResult result = solve(up.problem, GetParam(), options, up.guess);
  ASSERT_EQ(result.restarts->answer, 0);
  ASSERT_EQ(result.restarts->basins.size(), 1u);
  EXPECT_EQ(result.restarts->basins[0].starts, 2);
  EXPECT_EQ(result.cost, plain.cost);
  EXPECT_EQ(result.iterations, plain.iterations);
  EXPECT_EQ(result.log.size(), plain.log.size());
  for (int k = 0; k < up.problem.knots(); ++k)
    EXPECT_EQ(result.trajectory.u(k), plain.trajectory.u(k));
}

INSTANTIATE_TEST_SUITE_P(Solvers, RestartedSolver,
                         ::testing::Values("box_ddp", "box_fddp", "altro", "proxddp", "ipopt",
                                           "auto"));

TEST(Elsewhere, EndsIfAllStartsShareOneLeastViolation) {
  const ShootingProblem problem = double_integrator_move();
  // Status and violation of each start; the last entry repeats.
  using Ends = std::vector<std::pair<SolveStatus, double>>;
  const auto starts_of = [&](const Ends& ends) {
    std::size_t solves = 0;
    const auto next = [&](const Trajectory& start) {
      const auto [status, violation] = ends[std::min(solves++, ends.size() - 1)];
      SolveResult result = ends_at(problem, start, 0, status);
      result.residuals.constraint = violation;
      return result;
    };
    const Solve solve = [&](const Trajectory& start, const SolverOptions&, const SolverInfo*& by) {
      by = find_solver("altro");
      return next(start);
    };
    const Trajectory guess = problem.create_trajectory();
    const SolverInfo* used = nullptr;
    const SolveResult result =
        solve_from_elsewhere(problem, {}, guess, next(guess), 1, solve, nullptr, used);
    EXPECT_EQ(result.status, ends[0].first);
    EXPECT_EQ(result.message.find("the violation is the same from 5 starts") != std::string::npos,
              result.restarts->starts == 5)
        << result.message;
    return result.restarts->starts;
  };
  constexpr auto kLeast = SolveStatus::infeasible, kStuck = SolveStatus::line_search_failed;
  EXPECT_EQ(starts_of({{kLeast, 0.5}}), 5);
  EXPECT_EQ(starts_of({{kLeast, 0.5}, {kLeast, 0.5 + 1e-8}, {kLeast, 0.5}}), 5);
  EXPECT_EQ(starts_of({{kLeast, 0.5}, {kLeast, 0.501}, {kLeast, 0.5}}), 21) << "local ones";
  EXPECT_EQ(starts_of({{kLeast, 0.5}, {kLeast, 0.5}, {kStuck, 0.5}, {kLeast, 0.5}}), 21);
  EXPECT_EQ(starts_of({{kStuck, 0.5}, {kLeast, 0.5}}), 21);
}

// Each start follows the whole homotopy.
TEST(Restarts, CoverWholeHomotopies) {
  const SwingUp up;
  SolverOptions options = with_restarts(1, 3);
  options.threads = 2;
  options.homotopy = [](double share) {
    return std::make_shared<const ShootingProblem>(testing::pendulum_swing_up(8 - 4 * share));
  };
  const SolveResult result = solve(up.problem, "box_fddp", options, up.guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_EQ(result.restarts->starts, 4);
  EXPECT_GE(result.homotopy.size(), 2u);
}

}  // namespace
}  // namespace conddp
