#include "analysis/comparison/benchmark.hpp"

#include <gtest/gtest.h>

#include "analysis/comparison/random_instance.hpp"
#include "support/constrained_problems.hpp"
#include "support/small_problems.hpp"
#include "support/steps.hpp"

namespace conddp {
namespace {

BenchmarkRun run(const char* solver, const SolverOptions& options = {}, int repeat = 3) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  Trajectory guess = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k) guess.u(k).setConstant(0.1);
  return run_benchmark(problem, guess, solver, options, {.count = repeat});
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

TEST(Benchmark, MeasuresAutomaticChoiceLikeASolver) {
  const BenchmarkRun measured = run("auto"), chosen = run("box_fddp");
  EXPECT_EQ(measured.solver, "auto");
  EXPECT_TRUE(measured.solved);
  EXPECT_EQ(measured.check.cost, chosen.check.cost);
  EXPECT_EQ(run("no_solver").status, "refused");
}

TEST(Benchmark, TimesTheOnlySolveWithoutRepetition) {
  EXPECT_EQ(run("box_ddp", {}, 0).times.size(), 1u);
}

TEST(Benchmark, LongSolveIsNotRepeated) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  const auto times = [&](double longest_s) {
    return run_benchmark(problem, problem.create_trajectory(), "box_ddp", {},
                         {.count = 3, .longest_s = longest_s})
        .times.size();
  };
  EXPECT_EQ(times(0), 1u);
  EXPECT_EQ(times(1e9), 3u);
}

TEST(Benchmark, FlagsUnconfirmedConvergedStatus) {
  for (const char* status : {"converged", "max_iterations", "time_limit", "refused", "diverged"})
    for (const bool solved : {false, true}) {
      const BenchmarkRun measured{.status = status, .solved = solved};
      EXPECT_EQ(measured.kept_word(), solved || status != std::string("converged")) << status;
    }
}

TEST(Benchmark, DoesNotRepeatSolvesThatTimedOut) {
  const BenchmarkRun measured = run("box_ddp", {.max_time_s = 1e-9});
  EXPECT_EQ(measured.status, "time_limit");
  EXPECT_FALSE(measured.solved);
  EXPECT_EQ(measured.times.size(), 1u);
}

TEST(Benchmark, RejectionsAndFailuresHaveTheirStatus) {
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

/// Result of a mock solver for two steps x⁺ = x + u from 0 with cost ½ ‖u‖² and terminal constraint
/// x ≤ 0.
struct Pretended {
  double push = 0;    ///< first control, equal to the stationarity
  double jump = 0;    ///< gap of the first step
  double beyond = 0;  ///< violation at the end, caused by a control without cost
  SolveStatus status = SolveStatus::converged;
  std::vector<SolveTimes> times = {{}};  ///< of successive solves; the last entry repeats
};

BenchmarkRun run_of(const Pretended& pretended, int repeat = 0) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem free = testing::tracking_problem(
      linear_system(one, one, Eigen::VectorXd::Constant(1, pretended.beyond / 2)),
      Integrator::discrete, 2, 1, {0}, {{0}, {0}, {1}, {0}});
  const ShootingProblem problem =
      testing::with_constraints(free, {{.name = "end",
                                        .residual = state_residual(free.manifold()),
                                        .reference = {0},
                                        .lower = {-testing::kFree},
                                        .upper = {0},
                                        .first = 2,
                                        .last = 2}});
  std::size_t calls = 0;
  const SolverInfo solver{
      .name = "pretender",
      .constraints = ConstraintSupport::all,
      .run = [&](const ShootingProblem& of, const SolverOptions&, const Trajectory&) {
        SolveResult result(of);
        const double drift = pretended.beyond / 2;
        result.trajectory.u(0)[0] = pretended.push;
        result.trajectory.u(1)[0] = -pretended.push;
        result.trajectory.x(1)[0] = drift + pretended.push - pretended.jump;
        result.trajectory.x(2)[0] = 2 * drift - pretended.jump;
        result.status = pretended.status;
        result.residuals = {.stationarity = 1, .gap = 2, .constraint = 3};
        result.iterations = 2;
        for (const int sweeps : {5, 0, 3}) result.log.push_back({.gap = 2, .sweeps = sweeps});
        result.times = pretended.times[std::min(calls++, pretended.times.size() - 1)];
        return result;
      }};
  Trajectory answer = problem.create_trajectory();
  const BenchmarkRun run = run_benchmark(problem, problem.create_trajectory(), solver.name,
                                         std::array{&solver}, {}, {.count = repeat}, &answer);
  EXPECT_EQ(answer.u(0)[0], pretended.push);
  EXPECT_EQ(run.sweeps, 4) << "at least one an iteration";
  EXPECT_EQ(run.iterations, 2);
  EXPECT_EQ(run.claimed.gap, 2);
  return run;
}

// A check along another policy may exceed the tolerance tenfold.
TEST(Benchmark, CountsAnswersAsSolvedIfCheckConfirmsThem) {
  EXPECT_TRUE(run_of({}).solved);
  for (double Pretended::*residual : {&Pretended::push, &Pretended::jump, &Pretended::beyond}) {
    const double tolerance = residual == &Pretended::jump ? 1e-9 : 1e-6;
    Pretended good, bad;
    good.*residual = 9 * tolerance;
    bad.*residual = 11 * tolerance;
    EXPECT_TRUE(run_of(good).solved) << tolerance;
    const BenchmarkRun run = run_of(bad);
    EXPECT_FALSE(run.solved) << tolerance;
    EXPECT_FALSE(run.kept_word());
    EXPECT_NE(run.message.find("called converged, but the check finds"), std::string::npos);
    bad.status = SolveStatus::max_iterations;
    EXPECT_TRUE(run_of(bad).kept_word());
  }
  EXPECT_FALSE(run_of({.status = SolveStatus::cost_settled}).solved);
}

TEST(Benchmark, TimesExcludeFirstSolveAndTakeMedians) {
  Pretended pretended;
  pretended.times = {{.total = 9, .evaluate = 9, .differentiate = 9, .sweep = 9, .rollout = 9},
                     {.total = 1, .evaluate = 2, .differentiate = 6, .sweep = 7, .rollout = 3},
                     {.total = 5, .evaluate = 4, .differentiate = 5, .sweep = 2, .rollout = 2},
                     {.total = 2, .evaluate = 3, .differentiate = 4, .sweep = 1, .rollout = 1}};
  const BenchmarkRun run = run_of(pretended, 3);
  EXPECT_EQ(run.times, (std::vector<double>{1, 5, 2}));
  EXPECT_EQ(run.median.total, 2);
  EXPECT_EQ(run.median.evaluate, 3);
  EXPECT_EQ(run.median.differentiate, 5);
  EXPECT_EQ(run.median.sweep, 2);
  EXPECT_EQ(run.median.rollout, 2);
  EXPECT_EQ(run.spread(), 2);
  for (const SolveStatus status : {SolveStatus::time_limit, SolveStatus::interrupted}) {
    pretended.status = status;
    EXPECT_EQ(run_of(pretended, 3).times, std::vector<double>{9}) << "is not repeated";
  }
}

TEST(Benchmark, MedianOfEvenCountAveragesMiddleTwo) {
  EXPECT_EQ(median({3, 1, 2}), 2);
  EXPECT_EQ(median({4, 1, 2, 3}), 2.5);
  EXPECT_TRUE(std::isnan(median({})));
}

TEST(PerformanceProfile, IsShareWithinAMultipleOfTheBest) {
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

TEST(DataProfile, IsShareSolvedWithinAnEffort) {
  constexpr double kFailed = std::numeric_limits<double>::infinity();
  const auto profiles = data_profiles({"a", "b"}, {{3, 9}, {7, kFailed}, {3, 1}, {kFailed, 8}});
  using Steps = std::vector<std::pair<double, double>>;
  EXPECT_EQ(profiles[0].steps, (Steps{{3, 0.5}, {7, 0.75}}));
  EXPECT_EQ(profiles[1].steps, (Steps{{1, 0.25}, {8, 0.5}, {9, 0.75}}));
}

// A zero step would change the bits of a quaternion, and the state would count as a different one.
TEST(Perturbations, ExistIfOneSpreadIsSet) {
  EXPECT_FALSE(Perturbation{}.any());
  EXPECT_TRUE(Perturbation{.initial_state = 0.1}.any());
  EXPECT_TRUE(Perturbation{.guess = 0.1}.any());
}

TEST(RandomInstance, KeepsInitialStateExactlyWithoutPerturbation) {
  const ShootingProblem moved = perturb_initial_state(testing::quadrotor_move(), 0.3, 1);
  EXPECT_EQ(perturb_initial_state(moved, 0, 2).initial_state(), moved.initial_state());
}

TEST(RandomInstance, MovesInitialStateOnManifoldBySeed) {
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

TEST(RandomInstance, KeepsRememberedControls) {
  auto model =
      std::make_shared<KnotModel>(step_with(pendulum({}), Integrator::rk4, Memory::previous));
  auto end =
      std::make_shared<KnotModel>(step_with(pendulum({}), Integrator::none, Memory::previous));
  const ShootingProblem problem({0.1, 0.2, 0.7}, {{"all", model, {0.1}, {0.1}, {}}},
                                {"end", end, {0}, {1}, {}});
  const ShootingProblem instance = perturb_initial_state(problem, 0.5, 3);
  EXPECT_NE(instance.initial_state()[0], 0.1);
  EXPECT_NE(instance.initial_state()[1], 0.2);
  EXPECT_EQ(instance.initial_state()[2], 0.7);
}

}  // namespace
}  // namespace conddp
