#include <gtest/gtest.h>

#include "ocp/problem/problem.hpp"
#include "solvers/strategies/registry.hpp"
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

constexpr double kBound = 3;

SolveResult solve_soft(const ShootingProblem& problem, std::string_view solver) {
  SolverOptions options = testing::tight_options();
  options.tolerances.complementarity = 1e-9;
  options.max_time_s = 20;
  return solve(problem, solver, options, problem.create_trajectory());
}

/// Soft cuts of every kind; only `which`, or all if negative.
std::vector<Added> soft_cuts(const LinearQuadratic& lq, Softness softness, double weight,
                             int which = -1) {
  std::vector<Added> list;
  int i = 0;
  for (Added& cut : cuts(lq)) {
    if (which >= 0 && i++ != which) continue;
    cut.softness = softness;
    cut.weight = weight;
    list.push_back(cut);
  }
  return list;
}

Eigen::VectorXd values_of(const ShootingProblem& problem, const SolveResult& result) {
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(result.trajectory, evaluation);
  return evaluation.constraint;
}

double largest_miss(const ShootingProblem& problem, const SolveResult& result) {
  const Eigen::VectorXd g = values_of(problem, result);
  double largest = 0;
  for (const NodeConstraint& c : problem.soft_constraints())
    largest = std::max(largest, distance_to_set(*c.term, g.data() + c.row, c.lower, c.upper));
  return largest;
}

class SoftByDistance : public ::testing::TestWithParam<const char*> {};

TEST_P(SoftByDistance, OptimumMatchesAnIndependentMethod) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -kBound, kBound);
    for (const double weight : {0.1, 0.5}) {
      const ShootingProblem problem =
          with_constraints(*lq.problem, soft_cuts(lq, Softness::l1, weight));
      const Eigen::VectorXd expected =
          dense_optimum(problem, make_dense(lq, problem, -kBound, kBound));
      const SolveResult result = solve_soft(problem, GetParam());
      EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
      EXPECT_LT((controls_of(result.trajectory) - expected).cwiseAbs().maxCoeff(), 1e-6)
          << seed << ", weight " << weight;
      EXPECT_GT(largest_miss(problem, result), 1e-2) << "nothing is missed, so nothing is tested";
      EXPECT_EQ(result.residuals.constraint, 0) << "what is soft cannot be violated";
      double largest = 0;
      for (const NodeConstraint& c : problem.constraints()) {
        const auto nu = result.constraint_multipliers.segment(c.row, c.term->rows);
        largest = std::max(largest, c.term->has_bounds() ? nu.lpNorm<Eigen::Infinity>() / c.limit
                                                         : nu.norm() / c.limit);
      }
      EXPECT_NEAR(largest, 1, 1e-9) << "the multiplier of what is missed is at its limit";
    }
  }
}

TEST_P(SoftByDistance, HoldsLikeAHardOneAboveItsMultipliers) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -kBound, kBound);
    // Ipopt stalls at the tip of a soft cone, where its smooth surface and the slack meet.
    std::vector<Added> list = cuts(lq);
    if (std::string_view(GetParam()) == "ipopt") list.pop_back();
    const ShootingProblem hard = with_constraints(*lq.problem, list);
    const SolveResult best = solve_soft(hard, "altro");
    ASSERT_EQ(best.status, SolveStatus::converged);
    const double weight = 2 * best.constraint_multipliers.cwiseAbs().maxCoeff() / 0.25;
    for (Added& cut : list) cut.softness = Softness::l1, cut.weight = weight;
    const ShootingProblem soft = with_constraints(*lq.problem, list);
    const SolveResult result = solve_soft(soft, GetParam());
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    EXPECT_NEAR(result.cost, best.cost, 1e-7 * best.cost) << seed;
    EXPECT_LT((controls_of(result.trajectory) - controls_of(best.trajectory)).cwiseAbs().maxCoeff(),
              1e-6)
        << seed;
    EXPECT_LT(largest_miss(soft, result), 1e-8) << seed;
  }
}

TEST_P(SoftByDistance, CostEqualsItsWeightedDistances) {
  const LinearQuadratic lq(1, 4, {3, 2}, 8, -kBound, kBound);
  const ShootingProblem problem = with_constraints(*lq.problem, soft_cuts(lq, Softness::l1, 0.3));
  const SolveResult result = solve_soft(problem, GetParam());
  Evaluation free(*lq.problem);
  Evaluator(*lq.problem).evaluate(result.trajectory, free);
  double penalty = 0;
  const Eigen::VectorXd g = values_of(problem, result);
  for (const NodeConstraint& c : problem.soft_constraints()) {
    const double weight = 0.3 * problem.knot(c.node).cost_scale;
    if (!c.term->has_bounds()) {
      penalty += weight * distance_to_set(*c.term, g.data() + c.row, nullptr, nullptr);
      continue;
    }
    for (int i = 0; i < c.term->rows; ++i)
      penalty += weight * std::max({0.0, g[c.row + i] - c.upper[i], c.lower[i] - g[c.row + i]});
  }
  EXPECT_GT(penalty, 1e-2);
  EXPECT_NEAR(result.cost, free.cost.sum() + penalty, 1e-10);
  EXPECT_NEAR(result.log.back().cost, result.cost, 1e-10);
}

TEST_P(SoftByDistance, HasNoEffectWithoutAWeight) {
  const LinearQuadratic lq(1, 4, {3, 2}, 8, -kBound, kBound);
  const ShootingProblem problem = with_constraints(*lq.problem, soft_cuts(lq, Softness::l1, 0));
  const SolveResult result = solve_soft(problem, GetParam());
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_EQ(result.constraint_multipliers.lpNorm<Eigen::Infinity>(), 0);
  const SolveResult without = solve_soft(*lq.problem, GetParam());
  EXPECT_NEAR(result.cost, without.cost, 1e-9 * without.cost);
  EXPECT_GT(largest_miss(problem, result), 1e-2) << "nothing is missed, so nothing is tested";
}

// With this penalty, values of 1e-4 would already reach the limit, and nearly all rows are beyond
// it.
TEST(SoftPenalty, BeginsWithAPenaltyWithinItsLimits) {
  const LinearQuadratic lq(1, 4, {3, 2}, 8, -kBound, kBound);
  const ShootingProblem problem = with_constraints(*lq.problem, soft_cuts(lq, Softness::l1, 0.3));
  SolverOptions options = testing::tight_options();
  options.tolerances.complementarity = 1e-9;
  options.augmented_lagrangian.initial_penalty = 1e3;
  for (const char* solver : {"altro", "proxddp"}) {
    const SolveResult usual = solve_soft(problem, solver);
    const SolveResult result = solve(problem, solver, options, problem.create_trajectory());
    EXPECT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_NEAR(result.cost, usual.cost, 1e-8 * usual.cost) << solver;
    EXPECT_LT(result.log.front().constraint_penalty, 1) << solver;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, SoftByDistance,
                         ::testing::Values("altro", "proxddp", "ipddp", "ipopt"));

class SoftBySquare : public ::testing::TestWithParam<const char*> {};

TEST_P(SoftBySquare, OptimumMatchesAnIndependentMethod) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const bool bounded = std::string_view(GetParam()) != "fddp" &&
                         std::string_view(GetParam()) != "ilqr" &&
                         std::string_view(GetParam()) != "intro";
    const double bound = bounded ? kBound : testing::kFree;
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -bound, bound);
    const ShootingProblem problem = with_constraints(*lq.problem, soft_cuts(lq, Softness::l2, 5));
    const Eigen::VectorXd expected = dense_optimum(problem, make_dense(lq, problem, -bound, bound));
    const SolveResult result = solve_soft(problem, GetParam());
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    EXPECT_LT((controls_of(result.trajectory) - expected).cwiseAbs().maxCoeff(), 1e-6) << seed;
    EXPECT_GT(largest_miss(problem, result), 1e-2);
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, SoftBySquare,
                         ::testing::Values("ilqr", "fddp", "box_ddp", "box_fddp", "intro", "altro",
                                           "proxddp", "ipopt"));

/// The penalty of a missed soft cone has curvature, which determines the speed of Newton's method.
TEST(SoftConstraints, MissedConeEndsInFewNewtonSteps) {
  int missed = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -kBound, kBound);
    const ShootingProblem problem =
        with_constraints(*lq.problem, soft_cuts(lq, Softness::l1, 0.05, 2));
    const SolveResult result = solve_soft(problem, "altro");
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    missed += largest_miss(problem, result) > 1e-2;
    EXPECT_LE(result.log.back().newton, 5) << seed;
  }
  EXPECT_GE(missed, 1);
}

TEST(SoftConstraints, AreRejectedOnlyIfTheyAreNotCosts) {
  const LinearQuadratic lq(1, 4, {3, 2}, 8, -testing::kFree, testing::kFree);
  const ShootingProblem by_distance = with_constraints(*lq.problem, soft_cuts(lq, Softness::l1, 1));
  const ShootingProblem by_square = with_constraints(*lq.problem, soft_cuts(lq, Softness::l2, 1));
  for (const SolverInfo& solver : solvers()) {
    const bool all = solver.constraints == ConstraintSupport::all;
    EXPECT_EQ(unsupported(solver, by_distance).has_value(), !all) << solver.name;
    EXPECT_FALSE(unsupported(solver, by_square)) << solver.name;
  }
  EXPECT_NE(unsupported(*find_solver("intro"), by_distance)
                ->find("does not support the soft constraint 'cone'"),
            std::string::npos)
      << *unsupported(*find_solver("intro"), by_distance);
}

}  // namespace
}  // namespace conddp
