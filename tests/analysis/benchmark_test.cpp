#include "analysis/comparison/benchmark.hpp"

#include <gtest/gtest.h>

#include "analysis/comparison/performance_profile.hpp"
#include "analysis/comparison/random_instance.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

BenchmarkRun run(const char* solver, const SolverOptions& options = {}, int repeat = 3) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  Trajectory guess = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k) guess.u(k).setConstant(0.1);
  return run_benchmark(problem, guess, *find_solver(solver), options, {.count = repeat});
}

TEST(Benchmark, MeasuresASolve) {
  const BenchmarkRun measured = run("box_ddp");
  EXPECT_EQ(measured.solver, "box_ddp");
  EXPECT_EQ(measured.status, "converged");
  EXPECT_TRUE(measured.solved);
  EXPECT_GT(measured.iterations, 0);
  EXPECT_GE(measured.sweeps, measured.iterations);
  EXPECT_EQ(measured.times.size(), 3u);
  EXPECT_EQ(measured.median.total, median(measured.times));
  EXPECT_GT(measured.median.sweep, 0);
  EXPECT_GE(measured.spread(), 0);
}

TEST(Benchmark, WithoutRepetitionTheOneSolveIsTimed) {
  EXPECT_EQ(run("box_ddp", {}, 0).times.size(), 1u);
}

TEST(Benchmark, ALongSolveIsNotRepeated) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  const auto times = [&](double longest_s) {
    return run_benchmark(problem, problem.create_trajectory(), *find_solver("box_ddp"), {},
                         {.count = 3, .longest_s = longest_s})
        .times.size();
  };
  EXPECT_EQ(times(0), 1u);
  EXPECT_EQ(times(1e9), 3u);
}

TEST(Benchmark, ASolverKeepsItsWordUnlessItCallsConvergedWhatTheCheckDoesNotConfirm) {
  for (const char* status : {"converged", "max_iterations", "time_limit", "refused", "diverged"})
    for (const bool solved : {false, true}) {
      const BenchmarkRun measured{.status = status, .solved = solved};
      EXPECT_EQ(measured.kept_word(), solved || status != std::string("converged")) << status;
    }
}

TEST(Benchmark, ASolveThatRanOutOfTimeIsNotRepeated) {
  const BenchmarkRun measured = run("box_ddp", {.max_time_s = 1e-9});
  EXPECT_EQ(measured.status, "time_limit");
  EXPECT_FALSE(measured.solved);
  EXPECT_EQ(measured.times.size(), 1u);
}

TEST(Benchmark, RefusalsAndFailuresHaveTheirStatus) {
  const BenchmarkRun refused = run("fddp");
  EXPECT_EQ(refused.status, "refused");
  EXPECT_NE(refused.message.find("control bounds"), std::string::npos) << refused.message;
  EXPECT_TRUE(refused.times.empty());
  EXPECT_EQ(run("ilqr_clip", {.hessian = HessianChoice::exact}).status, "refused");
  const BenchmarkRun failed = run("box_ddp", {.max_iterations = 2});
  EXPECT_EQ(failed.status, "max_iterations");
  EXPECT_FALSE(failed.solved);
  EXPECT_GT(failed.check.stationarity, 1e-6);
}

TEST(Benchmark, MedianOfAnEvenNumberIsTheMeanOfTheMiddleTwo) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(PerformanceProfile, IsTheShareWithinAMultipleOfTheBest) {
  constexpr double kFailed = std::numeric_limits<double>::infinity();
  const auto profiles = performance_profiles(
      {"a", "b", "c"}, {{1, 2, kFailed}, {4, 2, kFailed}, {3, kFailed, kFailed}, {5, 5, kFailed}});
  EXPECT_EQ(profiles[0].share(1), 0.75);
  EXPECT_EQ(profiles[0].share(2), 1);
  EXPECT_EQ(profiles[1].share(1.9), 0.5);
  EXPECT_EQ(profiles[1].share(2), 0.75);
  EXPECT_EQ(profiles[1].share(100), 0.75);
  EXPECT_TRUE(profiles[2].steps.empty());
  EXPECT_EQ(profiles[2].share(100), 0);
  const auto zero = performance_profiles({"a", "b"}, {{0, 3}});
  EXPECT_EQ(zero[0].share(1), 1);
  EXPECT_EQ(zero[1].share(3.9), 0);
  EXPECT_EQ(zero[1].share(4), 1);
}

TEST(DataProfile, IsTheShareForSoMuchEffort) {
  constexpr double kFailed = std::numeric_limits<double>::infinity();
  const auto profiles = data_profiles({"a", "b"}, {{3, 9}, {7, kFailed}, {3, 1}, {kFailed, 8}});
  using Steps = std::vector<std::pair<double, double>>;
  EXPECT_EQ(profiles[0].steps, (Steps{{3, 0.5}, {7, 0.75}}));
  EXPECT_EQ(profiles[1].steps, (Steps{{1, 0.25}, {8, 0.5}, {9, 0.75}}));
}

// The bits of a quaternion would change by a step of nothing; then it would count as another state.
TEST(RandomInstance, LeavesTheInitialStateToTheBitWhereNothingIsAskedFor) {
  const ShootingProblem moved = perturb_initial_state(testing::quadrotor_move(), 0.3, 1);
  EXPECT_EQ(perturb_initial_state(moved, 0, 2).initial_state(), moved.initial_state());
}

TEST(RandomInstance, MovesTheInitialStateOnItsManifoldBySeed) {
  const ShootingProblem problem = testing::quadrotor_move();
  const StateManifold& manifold = problem.manifold();
  std::vector<double> before;
  double largest = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const ShootingProblem instance = perturb_initial_state(problem, 0.3, seed);
    EXPECT_EQ(instance.initial_state(), perturb_initial_state(problem, 0.3, seed).initial_state());
    EXPECT_NE(instance.initial_state(), before);
    before = instance.initial_state();
    std::vector<double> dx(problem.ndx());
    manifold.difference(problem.initial_state().data(), before.data(), dx.data());
    for (const double d : dx) {
      EXPECT_LE(std::abs(d), 0.3 + 1e-12);
      largest = std::max(largest, std::abs(d));
    }
    double norm = 0;
    for (int i = 3; i < 7; ++i) norm += before[i] * before[i];
    EXPECT_NEAR(norm, 1, 1e-14);
  }
  EXPECT_GT(largest, 0.25);
}

TEST(RandomInstance, LeavesRememberedControlsAlone) {
  auto model = std::make_shared<KnotModel>(pendulum({}), Integrator::rk4, ControlMemory::previous);
  auto end = std::make_shared<KnotModel>(pendulum({}), Integrator::none, ControlMemory::previous);
  const ShootingProblem problem({0.1, 0.2, 0.7}, {{"all", model, {0.1}, {0.1}, {}}},
                                {"end", end, {0}, {1}, {}});
  const ShootingProblem instance = perturb_initial_state(problem, 0.5, 3);
  EXPECT_NE(instance.initial_state()[0], 0.1);
  EXPECT_NE(instance.initial_state()[1], 0.2);
  EXPECT_EQ(instance.initial_state()[2], 0.7);
}

}  // namespace
}  // namespace conddp
