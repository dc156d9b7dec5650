// Effort of solves in time-independent counts: modified searches or later switches reach the same
// optimum with more effort.
#include <functional>

#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"

namespace conddp::testing {
namespace {

struct Effort {
  int iterations = 0, sweeps = 0, trials = 0;
};

Effort effort_of(const SolveResult& result) {
  Effort sum{.iterations = result.iterations};
  for (const IterationRecord& row : result.log) {
    sum.sweeps += row.sweeps;
    sum.trials += row.trials;
  }
  return sum;
}

/// A solve from constant controls, and its measured effort.
struct MeasuredSolve {
  const char* name;
  std::function<ShootingProblem()> problem;
  double control;
  const char* solver;
  Effort effort;
};

ShootingProblem with_goal(const ShootingProblem& free, const std::vector<double>& goal) {
  return with_constraints(free, {goal_constraint(free, goal)});
}
std::function<ShootingProblem()> published(int which) {
  return [which] { return std::move(published_cases()[which].problem); };
}
ShootingProblem far_goal() {
  const ShootingProblem mass = tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1,
                                                {0, 0}, {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  return with_goal(mass, {5, 0});
}

const std::vector<MeasuredSolve>& measured_solves() {
  static const std::vector<MeasuredSolve> solves = {
      {"unicycle", [] { return unicycle_parking(); }, 0.01, "ilqr", {17, 17, 21}},
      {"cartpole", [] { return cartpole_swing_up(); }, 0.01, "ddp", {64, 84, 121}},
      {"quadrotor", [] { return quadrotor_move(); }, 1.3, "ddp", {8, 13, 10}},
      {"pendulum", [] { return pendulum_swing_up(3); }, 0.1, "box_ddp", {51, 103, 68}},
      {"quadrotor", [] { return quadrotor_move(0, 6); }, 1.3, "box_ddp", {14, 17, 21}},
      {"unicycle", [] { return unicycle_parking(1); }, 0.01, "box_ddp", {12, 29, 15}},
      {"cartpole", [] { return cartpole_swing_up(); }, 0.01, "fddp", {75, 75, 156}},
      {"quadrotor", [] { return quadrotor_move(); }, 1.3, "fddp", {19, 19, 33}},
      {"pendulum", [] { return pendulum_swing_up(3); }, 0.1, "box_fddp", {45, 102, 66}},
      {"unicycle", [] { return unicycle_parking(1); }, 0.01, "box_fddp", {13, 30, 17}},
      {"landing", [] { return landing(60); }, 0.01, "box_fddp", {6, 6, 6}},
      {"pendulum_goal",
       [] {
         return with_goal(pendulum_swing_up(), {M_PI, 0});
       },
       0.1,
       "intro",
       {51, 51, 51}},
      {"integrator", published(0), 0, "altro", {6, 13, 5}},
      {"pendulum_goal", published(1), 0.1, "altro", {47, 107, 66}},
      {"obstacles", published(3), 0.01, "altro", {58, 224, 71}},
      {"far_goal", far_goal, 0, "altro", {11, 22, 11}},
      {"integrator", published(0), 0, "proxddp", {10, 16, 10}},
      {"pendulum_goal", published(1), 0.1, "proxddp", {47, 101, 68}},
      {"obstacles", published(3), 0.01, "proxddp", {52, 114, 52}},
      {"far_goal", far_goal, 0, "proxddp", {12, 20, 12}},
      {"pendulum_goal", published(1), 0.1, "ipopt", {59, 8, 60}},
      {"cartpole_goal", published(2), 0.01, "ipopt", {58, 4, 61}},
  };
  return solves;
}

class EffortOfASolve : public ::testing::TestWithParam<MeasuredSolve> {};

// A margin of a quarter plus two covers rounding on other machines.
TEST_P(EffortOfASolve, DoesNotExceedTheMeasuredEffort) {
  const auto& [name, make, control, solver, measured] = GetParam();
  const ShootingProblem problem = make();
  const Effort found = effort_of(solve(problem, solver, {}, constant_controls(problem, control)));
  const auto expect = [](int number, int limit, const char* what) {
    EXPECT_LE(number, limit + limit / 4 + 2) << what;
  };
  expect(found.iterations, measured.iterations, "iterations");
  expect(found.sweeps, measured.sweeps, "sweeps");
  expect(found.trials, measured.trials, "trials");
}

INSTANTIATE_TEST_SUITE_P(All, EffortOfASolve, ::testing::ValuesIn(measured_solves()),
                         [](const auto& suite) {
                           return std::string(suite.param.solver) + "_" + suite.param.name;
                         });

}  // namespace
}  // namespace conddp::testing
