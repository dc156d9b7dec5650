#include <cmath>

#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
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
  EXPECT_EQ(names_of(auto_solvers(constrained, {.segments = 2})), (Names{"proxddp"}));
  EXPECT_TRUE(auto_solvers(constrained, {.segments = 100}).empty());
  const SolveResult by_name = solve(constrained, "auto", {}, constrained.create_trajectory());
  const SolveResult altro = solve(constrained, "altro", {}, constrained.create_trajectory());
  EXPECT_EQ(by_name.status, SolveStatus::converged);
  EXPECT_EQ(by_name.cost, altro.cost);
}

/// A solver that gets nowhere.
SolverInfo failing() {
  return {.name = "failing",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .run = [](const ShootingProblem& problem, const SolverOptions& options,
                    const Trajectory& guess) {
            SolveResult result(problem);
            result.status = options.max_iterations > 1 ? SolveStatus::line_search_failed
                                                       : SolveStatus::max_iterations;
            result.iterations = 7;
            result.trajectory = guess;
            return result;
          }};
}

TEST(AutoSolver, GoesOnToTheNextWhereOneDoesNotConverge) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolverInfo first = failing(), *box = find_solver("box_ddp");
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&first, box};
  const SolveResult result = solve(problem, both, {}, guess, used);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(used, box);
  EXPECT_TRUE(
      result.message.starts_with("failing ended as line_search_failed after 7 iterations; "))
      << result.message;
  // A limit is the user's word, and no defect of a solver.
  const SolveResult limited = solve(problem, both, {.max_iterations = 1}, guess, used);
  EXPECT_EQ(limited.status, SolveStatus::max_iterations);
  EXPECT_EQ(used, &first);
}

/// A solver that does not get there within the default limit.
SolverInfo endless(double stationarity) {
  return {.name = "endless",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .run = [stationarity](const ShootingProblem& problem, const SolverOptions&,
                                const Trajectory& guess) {
            SolveResult result(problem);
            result.status = SolveStatus::max_iterations;
            result.iterations = 1000;
            result.residuals.stationarity = stationarity;
            result.trajectory = guess;
            return result;
          }};
}

TEST(AutoSolver, TheDefaultLimitOfIterationsEndsOneSolverAlone) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolverInfo first = endless(1), *box = find_solver("box_ddp");
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&first, box};
  EXPECT_EQ(solve(problem, both, {}, guess, used).status, SolveStatus::converged);
  EXPECT_EQ(used, box);
  EXPECT_EQ(solve(problem, both, {.max_iterations = 999}, guess, used).status,
            SolveStatus::max_iterations);
  EXPECT_EQ(used, &first);
}

TEST(AutoSolver, HasTheSecondAnswerWhereTheFirstOneDiverged) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const SolverInfo far = endless(1e20), near = endless(1);
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&far, &near};
  const SolveResult result = solve(problem, both, {}, problem.create_trajectory(), used);
  EXPECT_EQ(used, &near);
  EXPECT_EQ(result.residuals.stationarity, 1);
  EXPECT_TRUE(result.message.starts_with("endless ended as diverged after 1000 iterations; "))
      << result.message;
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

TEST(AutoSolver, HasALaterAnswerThatIsALeastViolation) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -1, 1);
  const ShootingProblem problem = testing::with_constraints(
      *lq.problem, {testing::goal_constraint(*lq.problem, {100, 100, 100, 100})});
  const SolverInfo first = failing();
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&first, find_solver("altro")};
  const SolveResult result = solve(problem, both, {}, problem.create_trajectory(), used);
  EXPECT_EQ(result.status, SolveStatus::infeasible);
  EXPECT_EQ(used, both[1]);
  EXPECT_TRUE(result.message.starts_with("failing ended as line_search_failed after "))
      << result.message;
}

/// A solver of Ipopt's name whose violation falls in the iterations before `last` alone.
SolverInfo standing_after(int last) {
  return {.name = "ipopt",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .run = [last](const ShootingProblem& problem, const SolverOptions& options,
                        const Trajectory& guess) {
            SolveResult result(problem);
            IterationRecord row;
            for (row.iteration = 0; row.iteration < 500; ++row.iteration) {
              row.constraint = std::max(1.0, std::pow(2.0, last - row.iteration));
              if (options.on_iteration) options.on_iteration(row);
              if (!options.interrupted || !options.interrupted()) continue;
              result.status = SolveStatus::interrupted;
              break;
            }
            if (row.iteration == 500) result.status = SolveStatus::max_iterations;
            result.iterations = row.iteration;
            result.trajectory = guess;
            return result;
          }};
}

TEST(AutoSolver, EndsIpoptWhereItsViolationStands) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = problem.create_trajectory();
  const SolverInfo first = failing(), stands = standing_after(40);
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&first, &stands}, alone{&stands};
  int rows = 0;
  SolverOptions options;
  options.on_iteration = [&](const IterationRecord&) { ++rows; };
  const SolveResult result = solve(problem, both, options, guess, used);
  EXPECT_EQ(result.status, SolveStatus::line_search_failed);
  EXPECT_NE(result.message.find("; ipopt ended as line_search_failed after 140 iterations"),
            std::string::npos)
      << result.message;
  EXPECT_EQ(rows, 141);
  EXPECT_EQ(solve(problem, alone, {}, guess, used).iterations, 500) << "who asks for it gets it";
  options.interrupted = [&] { return true; };
  EXPECT_EQ(solve(problem, alone, options, guess, used).status, SolveStatus::interrupted);
}

}  // namespace
}  // namespace conddp
