#include "solvers/strategies/reusable_solver.hpp"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluation_memory.hpp"
#include "support/constrained_problems.hpp"

namespace conddp {
namespace {

/// Compares every number of two answers except times.
void expect_same(const SolveResult& a, const SolveResult& b) {
  EXPECT_EQ(a.status, b.status);
  EXPECT_EQ(a.message, b.message);
  EXPECT_EQ(a.start, b.start);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.residuals.stationarity, b.residuals.stationarity);
  EXPECT_EQ(a.costates, b.costates);
  EXPECT_EQ(a.state_gradient, b.state_gradient);
  EXPECT_EQ(a.log.size(), b.log.size());
  EXPECT_EQ(a.constraint_multipliers, b.constraint_multipliers);
  ASSERT_EQ(a.control_gradient.size(), b.control_gradient.size());
  for (int k = 0; k < a.trajectory.knots(); ++k) {
    EXPECT_EQ(a.trajectory.x(k + 1), b.trajectory.x(k + 1));
    EXPECT_EQ(a.trajectory.u(k), b.trajectory.u(k));
    EXPECT_EQ(a.feedback.K[k], b.feedback.K[k]);
    EXPECT_EQ(a.control_gradient[k], b.control_gradient[k]);
  }
}

TEST(ReusableSolver, AnswersLikeASeparateSolver) {
  for (const char* name : {"ddp", "box_fddp", "altro", "proxddp", "ipopt"}) {
    ShootingProblem problem = testing::cartpole_swing_up();
    ReusableSolver solver(problem, name, {});
    Trajectory guess = testing::constant_controls(problem, 0.01);
    for (const double angle : {0.0, 0.3, -0.2}) {
      problem.set_initial_state(std::vector<double>{0, angle, 0, 0});
      SCOPED_TRACE(name);
      const SolveResult fresh = solve(problem, name, {}, guess);
      const SolveResult& again = solver.solve(guess);
      expect_same(again, fresh);
      guess = fresh.trajectory;
    }
  }
}

/// A mass sent to 1, with costs on a wall and a speed, a hard band, and control bounds.
struct MassNumbers {
  double wall, wall_weight, speed, speed_weight, band;
};
ShootingProblem mass_between(const MassNumbers& numbers) {
  const ShootingProblem free =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {0, 0},
                                {{1, 0}, {1, 0.1}, {0.01}, {10, 10}}, -5, 5);
  const auto place = coordinate_residual(free.manifold(), {0}),
             speed = coordinate_residual(free.manifold(), {1});
  const double none = testing::kFree;
  return testing::with_constraints(free, {{.name = "wall",
                                           .residual = place,
                                           .reference = {0},
                                           .lower = {-none},
                                           .upper = {numbers.wall},
                                           .first = 1,
                                           .last = 20,
                                           .softness = Softness::l1,
                                           .weight = numbers.wall_weight},
                                          {.name = "speed",
                                           .residual = speed,
                                           .reference = {0},
                                           .lower = {-numbers.speed},
                                           .upper = {numbers.speed},
                                           .first = 1,
                                           .last = 20,
                                           .softness = Softness::l2,
                                           .weight = numbers.speed_weight},
                                          {.name = "band",
                                           .residual = place,
                                           .reference = {0},
                                           .lower = {numbers.band},
                                           .upper = {none},
                                           .first = 8,
                                           .last = 20}});
}

void take_numbers(const ShootingProblem& from, ShootingProblem& to) {
  std::vector<KnotNumbers> nodes;
  for (int k = 0; k <= from.knots(); ++k)
    nodes.push_back({from.knot(k).dt, from.knot(k).cost_scale, from.knot(k).parameters});
  to.set_numbers(nodes);
}

// Changed bounds and weights are read again.
TEST(ReusableSolver, NewNumbersSolveLikeAFreshSolver) {
  const MassNumbers many[] = {{0.9, 0.05, 0.6, 40, 0.3},
                              {0.5, 3, 0.6, 40, 0.3},
                              {0.9, 0.05, 0.4, 5, 0.3},
                              {0.7, 0.3, 0.9, 90, 0.6}};
  for (const char* name : {"altro", "proxddp", "ipopt"}) {
    ShootingProblem problem = mass_between(many[0]);
    ReusableSolver solver(problem, name, {});
    const Trajectory guess = testing::constant_controls(problem, 0.5);
    for (const MassNumbers& numbers : many) {
      SCOPED_TRACE(name + std::string(" ") + std::to_string(numbers.wall));
      const ShootingProblem own = mass_between(numbers);
      take_numbers(own, problem);
      const SolveResult fresh = solve(own, name, {}, guess);
      EXPECT_EQ(fresh.status, SolveStatus::converged) << fresh.message;
      expect_same(solver.solve(guess), fresh);
    }
  }
}

/// A pendulum that must stand, with this step length.
ShootingProblem pendulum_of(double dt) {
  return testing::tracking_problem(pendulum({}), Integrator::semi_implicit_euler, 12, dt, {0.4, 0},
                                   {{0, 0}, {1, 0.1}, {0.01}, {10, 1}}, -8, 8);
}

TEST(ReusableSolver, TakesStepsOfOtherLengths) {
  ShootingProblem problem = pendulum_of(0.05);
  ReusableSolver solver(problem, "box_fddp", {});
  const Trajectory guess = testing::constant_controls(problem, 0.1);
  for (const double dt : {0.05, 0.02, 0.08}) {
    SCOPED_TRACE(dt);
    const ShootingProblem own = pendulum_of(dt);
    take_numbers(own, problem);
    expect_same(solver.solve(guess), solve(own, "box_fddp", {}, guess));
  }
}

/// The problem with only the first knots of each phase, at most `knots`.
ShootingProblem beginnings(const ShootingProblem& problem, int knots) {
  std::vector<Phase> phases = problem.phases();
  for (Phase& phase : phases) {
    const int count = std::min(knots, phase.knots());
    phase.dt.resize(count);
    phase.cost_scale.resize(count);
    phase.parameters.resize(count * phase.model->parameter_count());
  }
  return ShootingProblem(problem.initial_state(), std::move(phases), problem.terminal());
}

// Neither per-model workspaces nor shared matrices keep state between solvers.
TEST(ReusableSolver, AnswersAreIndependentOfSharedMemory) {
  const ShootingProblem longer = testing::landing(), shorter = beginnings(longer, 8);
  const Trajectory guess = testing::constant_controls(longer, 0.1),
                   other = testing::constant_controls(shorter, 0.1);
  const auto memory = std::make_shared<EvaluationMemory>(1);
  for (const char* name : {"fddp", "box_fddp", "altro"}) {
    SCOPED_TRACE(name);
    ReusableSolver first(longer, name, {}, memory), second(shorter, name, {}, memory);
    for (int turn = 0; turn < 2; ++turn) {
      expect_same(first.solve(guess), solve(longer, name, {}, guess));
      second.exchange_memory(first);
      expect_same(second.solve(other), solve(shorter, name, {}, other));
      first.exchange_memory(second);
    }
  }
}

TEST(ReusableSolver, ForgetsAFailedSolve) {
  ShootingProblem problem = testing::cartpole_swing_up();
  ReusableSolver solver(problem, "ddp", {});
  const Trajectory good = testing::constant_controls(problem, 0.01);
  const Trajectory bad = testing::constant_controls(problem, 1e200);
  EXPECT_EQ(solver.solve(bad).status, SolveStatus::diverged);
  EXPECT_TRUE(solver.solve(bad).control_gradient.empty());
  expect_same(solver.solve(good), solve(problem, "ddp", {}, good));
  EXPECT_TRUE(solver.solve(bad).control_gradient.empty());
}

TEST(ReusableSolver, UsesLastGainsAndMeasuresItsAnswer) {
  ShootingProblem problem = testing::cartpole_swing_up();
  Trajectory guess = testing::constant_controls(problem, 0.01);
  Evaluator(problem).simulate(guess);
  for (const char* name : {"ddp", "box_fddp"}) {
    SCOPED_TRACE(name);
    ReusableSolver one(problem, name, {.max_iterations = 1});
    const SolveResult whole = one.solve(guess), quick = one.iterate(guess);
    EXPECT_EQ(quick.status, SolveStatus::max_iterations);
    EXPECT_EQ(quick.iterations, 1);
    EXPECT_NEAR(quick.cost, whole.cost, 1e-13 * whole.cost);
    EXPECT_NEAR(quick.residuals.gap, whole.residuals.gap, 1e-13);
    EXPECT_EQ(quick.residuals.stationarity, whole.log[0].stationarity);
    // The policy that led from the guess to the answer leads back.
    const int last = problem.knots() - 1;
    for (int k = 0; k <= last; ++k) {
      EXPECT_EQ(quick.trajectory.u(k), whole.trajectory.u(k));
      EXPECT_EQ(quick.feedback.K[k].rows(), problem.nu(k));
    }
    const Eigen::VectorXd dx = quick.trajectory.x(1) - guess.x(1);
    const double followed = quick.trajectory.u(1)[0] - (quick.feedback.K[1] * dx)[0];
    EXPECT_NEAR(followed, guess.u(1)[0] + whole.log[1].step * quick.feedback.k[1][0], 1e-9);
    EXPECT_NE(quick.feedback.K[last], whole.feedback.K[last]);
  }
}

TEST(ReusableSolver, IteratesToTheSameConvergedAnswer) {
  ShootingProblem problem = testing::cartpole_swing_up();
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  for (const char* name : {"ddp", "box_fddp", "altro", "proxddp"}) {
    SCOPED_TRACE(name);
    ReusableSolver solver(problem, name, {});
    const SolveResult whole = solver.solve(guess);
    expect_same(solver.iterate(guess), whole);
  }
}

// Each iteration starts from the trajectory and the multipliers of the last one.
TEST(ReusableSolver, RealTimeIterationsReachTheConstrainedOptimum) {
  const ShootingProblem problem = mass_between({10, 1, 10, 1, 0.9});
  auto multipliers = std::make_shared<DualGuess>();
  multipliers->constraints = Eigen::VectorXd::Zero(problem.constraint_rows());
  SolverOptions options{.max_iterations = 1, .multipliers = multipliers};
  options.augmented_lagrangian.initial_penalty = 100;
  for (const char* name : {"altro", "proxddp"}) {
    SCOPED_TRACE(name);
    multipliers->constraints.setZero();
    Trajectory guess = testing::constant_controls(problem, 0.5);
    const SolveResult best = solve(problem, name, {}, guess);
    ReusableSolver solver(problem, name, options);
    const SolveResult* answer = nullptr;
    for (int i = 0; i < 60; ++i) {
      answer = &solver.iterate(guess);
      EXPECT_LE(answer->iterations, 1);
      guess = answer->trajectory;
      multipliers->constraints = answer->constraint_multipliers;
    }
    EXPECT_NEAR(answer->cost, best.cost, 1e-6 * best.cost);
    EXPECT_LE(answer->residuals.constraint, 1e-6);
    EXPECT_GT(best.constraint_multipliers.cwiseAbs().maxCoeff(), 1e-3);
  }
}

// Their barrier stays, so that they end near the optimum, inside of the constraints.
TEST(ReusableSolver, RealTimeInteriorPointsFollowNewNumbers) {
  const MassNumbers first{10, 1, 10, 1, 0.3}, second{10, 1, 10, 1, 0.9};
  ShootingProblem problem = mass_between(first);
  ReusableSolver solver(problem, "ipddp", {.max_iterations = 1});
  Trajectory guess = testing::constant_controls(problem, 0.5);
  for (const MassNumbers& numbers : {first, second}) {
    const ShootingProblem own = mass_between(numbers);
    take_numbers(own, problem);
    const SolveResult best = solve(own, "ipddp", {}, guess);
    const SolveResult* answer = nullptr;
    for (int i = 0; i < 100; ++i) {
      answer = &solver.iterate(guess);
      EXPECT_EQ(answer->iterations, 1) << answer->message;
      guess = answer->trajectory;
    }
    EXPECT_NEAR(answer->cost, best.cost, 1e-2 * best.cost);
    EXPECT_LE(answer->residuals.constraint, 1e-4);
  }
}

// Without a limit, searches for the active set take dozens of sweeps here.
TEST(ReusableSolver, RealTimeIterationsLimitTheirSweeps) {
  for (const ShootingProblem& problem : {testing::landing(5), testing::acrobot_swing_up(5)}) {
    const Trajectory guess = testing::constant_controls(problem, 0.01);
    ReusableSolver solver(problem, "box_fddp", {.max_iterations = 1});
    const SolveResult& quick = solver.iterate(guess);
    EXPECT_LE(quick.log.back().sweeps, 8);
    EXPECT_EQ(quick.iterations, 1);
  }
}

TEST(ReusableSolver, BeginsWithAvailableMultipliers) {
  const ShootingProblem free = testing::cartpole_swing_up();
  const ShootingProblem problem =
      testing::with_constraints(free, {testing::goal_constraint(free, {0, M_PI, 0, 0})});
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  SolverOptions options;
  options.max_iterations = 3;
  auto known = std::make_shared<DualGuess>();
  known->constraints = Eigen::VectorXd::Ones(problem.constraint_rows());
  options.multipliers = known;
  ReusableSolver solver(problem, "altro", options);
  const SolveResult& result = solver.solve(guess);
  expect_same(result, solve(problem, "altro", options, guess));
  EXPECT_NE(result.start.find("multipliers"), std::string::npos) << result.start;
  known = std::make_shared<DualGuess>();
  options.multipliers = known;
  ReusableSolver unconstrained(free, "box_fddp", options);
  expect_same(unconstrained.solve(guess), solve(free, "box_fddp", options, guess));
}

TEST(ReusableSolver, RejectsUnsupportedProblems) {
  const ShootingProblem problem = testing::cartpole_swing_up(3);
  EXPECT_THROW(ReusableSolver(problem, "newton", {}), std::invalid_argument);
  EXPECT_THROW(ReusableSolver(problem, "ipopt", {}).iterate(problem.create_trajectory()),
               std::logic_error);
  EXPECT_THROW(ReusableSolver(problem, "ddp", {}), std::invalid_argument);
  EXPECT_THROW(ReusableSolver(problem, "box_ddp", {.restarts = {.count = 2}}),
               std::invalid_argument);
  EXPECT_THROW(ReusableSolver(problem, "box_ddp", {.max_iterations = -1}), std::invalid_argument);
}

TEST(ShootingProblem, HasAnInitialStateOfItsSize) {
  ShootingProblem problem = testing::cartpole_swing_up();
  problem.set_initial_state(std::vector<double>{1, 2, 3, 4});
  EXPECT_EQ(problem.create_trajectory().x(3), Eigen::Vector4d(1, 2, 3, 4));
  EXPECT_THROW(problem.set_initial_state(std::vector<double>{1, 2}), std::invalid_argument);
}

}  // namespace
}  // namespace conddp
