#include <cmath>

#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/conic_optimality.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

using testing::Added;
using testing::controls_of;
using testing::cuts;
using testing::dense_optimum;
using testing::LinearQuadratic;
using testing::make_dense;
using testing::with_constraints;

SolverOptions proxddp_options() {
  SolverOptions options = testing::tight_options();
  options.max_time_s = 20;
  return options;
}

SolveResult run(const ShootingProblem& problem, std::string_view solver = "proxddp") {
  return solve(problem, solver, proxddp_options(), problem.create_trajectory());
}

TEST(Proxddp, ReachesOptimaOfThePublishedCases) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    SolverOptions options;
    options.tolerances.constraint = 1e-8;
    const SolveResult result =
        solve(problem, "proxddp", options, testing::constant_controls(problem, control));
    EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
    // Between discs there are several routes, 2e-4 apart in cost.
    EXPECT_NEAR(result.cost, cost, (name == "three obstacles" ? 3e-4 : 1e-4) * cost) << name;
    EXPECT_LE(result.residuals.constraint, 1e-8) << name;
    EXPECT_LE(result.residuals.stationarity, 1e-6) << name;
    EXPECT_LE(result.residuals.complementarity, 1e-6) << name;
  }
}

TEST(Proxddp, MatchesIndependentMethodAndAltroOnConvexProblems) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -3, 3);
    const ShootingProblem problem = with_constraints(*lq.problem, cuts(lq));
    const Eigen::VectorXd expected = dense_optimum(problem, make_dense(lq, problem, -3, 3));
    const SolveResult result = run(problem);
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    EXPECT_LT((controls_of(result.trajectory) - expected).cwiseAbs().maxCoeff(), 1e-7) << seed;
    EXPECT_LT(testing::control_distance(result, run(problem, "altro")), 1e-7) << seed;
    EXPECT_GT(result.constraint_multipliers.cwiseAbs().maxCoeff(), 1e-3) << seed;
  }
}

TEST(Proxddp, AgreesWithAltroOnLongerConvexProblems) {
  for (const unsigned seed : {11u, 12u}) {
    const LinearQuadratic lq(seed, 10, {6, 5}, 15, -5, 5);
    const SolveResult free = run(*lq.problem, "box_fddp");
    ASSERT_EQ(free.status, SolveStatus::converged) << free.message;
    const ShootingProblem problem =
        with_constraints(*lq.problem, cuts(*lq.problem, free.trajectory));
    const SolveResult result = run(problem);
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    EXPECT_GT(testing::control_distance(result, free), 1e-2) << seed;
    EXPECT_LT(testing::control_distance(result, run(problem, "altro")), 1e-7) << seed;
  }
}

// The linear model of a linear-quadratic problem is exact. If the sweeps find the horizon's active
// rows, one full step minimizes the augmented Lagrangian across any rows and control bounds.
TEST(Proxddp, OneStepMinimizesTheLinearQuadraticAugmentedLagrangian) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -3, 3);
    std::vector<Added> bounds = cuts(lq);
    bounds.pop_back();
    const ShootingProblem problem = with_constraints(*lq.problem, bounds);
    const SolveResult result = run(problem);
    ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
    int outer = 0;
    for (const IterationRecord& row : result.log) {
      if (row.iteration > 0) {
        EXPECT_EQ(row.step, 1) << seed << ' ' << row.iteration;
      }
      outer = row.outer;
    }
    EXPECT_LE(result.iterations, outer + 1) << seed;
  }
}

TEST(Proxddp, PenaltiesGrowOnlyIfMultipliersStay) {
  const auto cases = testing::published_cases();
  const SolveResult result =
      solve(cases[2].problem, "proxddp", {}, testing::constant_controls(cases[2].problem, 0.01));
  const SolverOptions::AugmentedLagrangian defaults;
  const double largest = result.log.back().constraint_penalty;
  const double growths = std::log10(largest / defaults.initial_penalty);
  EXPECT_NEAR(growths, std::round(growths), 1e-9);
  EXPECT_LT(growths, result.log.back().outer);
}

}  // namespace
}  // namespace conddp
