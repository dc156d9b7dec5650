#include <gtest/gtest.h>

#include "solvers/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

using Names = std::vector<std::string>;

Names names_of(const std::vector<const SolverInfo*>& list) {
  Names names;
  for (const SolverInfo* info : list) names.emplace_back(info->name);
  return names;
}

TEST(AutoSolver, IsChosenByTheProblemAndTheOptions) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -1, 1);
  const ShootingProblem constrained = testing::with_constraints(*lq.problem, testing::cuts(lq));
  EXPECT_EQ(names_of(auto_solvers(*lq.problem, {})), (Names{"box_fddp", "ipopt"}));
  EXPECT_EQ(names_of(auto_solvers(constrained, {})), (Names{"altro", "proxddp", "ipopt"}));
  EXPECT_EQ(names_of(auto_solvers(constrained, {.legs = 2})), (Names{"altro", "proxddp"}));
  EXPECT_TRUE(auto_solvers(constrained, {.legs = 100}).empty());
  const SolveResult by_name = solve(constrained, "auto", {}, constrained.create_trajectory());
  const SolveResult altro = solve(constrained, "altro", {}, constrained.create_trajectory());
  EXPECT_EQ(by_name.status, SolveStatus::converged);
  EXPECT_EQ(by_name.cost, altro.cost);
}

// Cutting controls off at their bounds ends short of an optimum here.
TEST(AutoSolver, GoesOnToTheNextWhereOneDoesNotConverge) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolverInfo *clip = find_solver("ilqr_clip"), *box = find_solver("box_ddp");
  ASSERT_EQ(solve(problem, *clip, {}, guess).status, SolveStatus::line_search_failed);
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{clip, box};
  const SolveResult result = solve(problem, both, {}, guess, used);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(used, box);
  EXPECT_TRUE(result.message.starts_with("ilqr_clip ended as line_search_failed after "))
      << result.message;
  // A limit is the user's word, and no defect of a solver.
  const SolveResult limited = solve(problem, both, {.max_iterations = 1}, guess, used);
  EXPECT_EQ(limited.status, SolveStatus::max_iterations);
  EXPECT_EQ(used, clip);
}

TEST(AutoSolver, HasTheFirstAnswerWhereNoneConverges) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -1, 1);
  // A goal that bounded controls do not reach.
  const ShootingProblem problem = testing::with_constraints(
      *lq.problem, {testing::goal_constraint(*lq.problem, {100, 100, 100, 100})});
  const Trajectory guess = problem.create_trajectory();
  const SolveResult altro = solve(problem, "altro", {}, guess);
  ASSERT_EQ(altro.status, SolveStatus::infeasible);
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{find_solver("altro"), find_solver("proxddp")};
  const SolveResult result = solve(problem, both, {}, guess, used);
  EXPECT_EQ(result.status, SolveStatus::infeasible);
  EXPECT_EQ(used, both[0]);
  EXPECT_EQ(result.cost, altro.cost);
  EXPECT_NE(result.message.find("; proxddp ended as infeasible after "), std::string::npos)
      << result.message;
}

}  // namespace
}  // namespace conddp
