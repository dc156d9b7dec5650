#include <array>

#include <gtest/gtest.h>

#include "ocp/problem/cost_scale.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/strategies.hpp"
#include "support/constrained_problems.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// Parking with speed bounds and, if `goal`, exactly at a goal.
ShootingProblem parking(double scale, bool goal) {
  const ShootingProblem free = testing::unicycle_parking(0.6);
  const ShootingProblem problem =
      goal ? testing::with_constraints(free, {testing::goal_constraint(free, {0, 0, 0})})
           : scale_costs(free, 1);
  return scale_costs(problem, scale);
}

TEST(ScaledSolve, MotionIsIndependentOfCostUnits) {
  for (const bool goal : {false, true})
    for (const char* solver : {"box_fddp", "altro", "proxddp", "ipopt"}) {
      if (goal && std::string_view(solver) == "box_fddp") continue;
      std::vector<SolveResult> results;
      for (const double scale : {0x1p-30, 0x1p-40, 0x1p30}) {
        const ShootingProblem problem = parking(scale, goal);
        const Trajectory guess = testing::constant_controls(problem, 0.01);
        SolveResult& result = results.emplace_back(solve(problem, solver, {}, guess));
        EXPECT_EQ(result.status, SolveStatus::converged) << solver << scale << result.message;
        EXPECT_NE(cost_scale(problem), 1);
        result.cost /= scale;
        result.residuals.stationarity /= scale;
        result.costates /= scale;
        result.constraint_multipliers /= scale;
        result.log.back().merit /= scale;
      }
      for (std::size_t i = 1; i < results.size(); ++i) {
        EXPECT_EQ(results[i].trajectory.x(5), results[0].trajectory.x(5)) << solver;
        EXPECT_EQ(results[i].cost, results[0].cost) << solver;
        EXPECT_EQ(results[i].residuals.stationarity, results[0].residuals.stationarity) << solver;
        EXPECT_EQ(results[i].costates, results[0].costates) << solver;
        EXPECT_EQ(results[i].constraint_multipliers, results[0].constraint_multipliers) << solver;
        EXPECT_EQ(results[i].log.back().merit, results[0].log.back().merit) << solver;
      }
      const ShootingProblem usual = parking(1, goal);
      const SolveResult result = solve(usual, solver, {}, testing::constant_controls(usual, 0.01));
      EXPECT_EQ(cost_scale(usual), 1);
      EXPECT_NEAR(result.cost, results[0].cost, 1e-6 * result.cost) << solver;
    }
}

TEST(ScaledSolve, InitialMultipliersUseCostUnits) {
  const ShootingProblem problem = parking(0x1p-30, true);
  SolverOptions options;
  std::vector<double> costs;
  options.on_iteration = [&](const IterationRecord& row) { costs.push_back(row.cost); };
  const SolveResult first =
      solve(problem, "altro", options, testing::constant_controls(problem, 0.01));
  ASSERT_EQ(first.status, SolveStatus::converged);
  ASSERT_EQ(costs.size(), first.log.size());
  for (std::size_t i = 0; i < costs.size(); ++i) EXPECT_EQ(costs[i], first.log[i].cost);
  options.multipliers = std::make_shared<const DualGuess>(
      DualGuess{first.constraint_multipliers, first.costates, first.control_gradient});
  EXPECT_LE(solve(problem, "altro", options, first.trajectory).iterations, 2);
}

}  // namespace
}  // namespace conddp
