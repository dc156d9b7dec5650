// Initial multipliers: a solve from its own answer finishes immediately.
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

std::shared_ptr<DualGuess> multipliers_of(const SolveResult& result) {
  auto guess = std::make_shared<DualGuess>();
  guess->constraints = result.constraint_multipliers;
  guess->costates = result.costates;
  guess->control_gradient = result.control_gradient;
  return guess;
}

SolverOptions small_violations() {
  SolverOptions options;
  options.tolerances.constraint = 1e-8;
  return options;
}

class DualGuesses : public ::testing::TestWithParam<const char*> {};

TEST_P(DualGuesses, OwnAnswerEndsInTwoIterations) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    SolverOptions options = small_violations();
    const SolveResult cold =
        solve(problem, GetParam(), options, testing::constant_controls(problem, control));
    ASSERT_EQ(cold.status, SolveStatus::converged) << name << ": " << cold.message;
    options.multipliers = multipliers_of(cold);
    const SolveResult warm = solve(problem, GetParam(), options, cold.trajectory);
    EXPECT_EQ(warm.status, SolveStatus::converged) << name << ": " << warm.message;
    EXPECT_LE(warm.iterations, 2) << name;
    EXPECT_GT(cold.iterations, 3) << name;
    EXPECT_NEAR(warm.cost, cold.cost, 1e-6 * cold.cost) << name;
    EXPECT_NE(warm.start.find("multipliers"), std::string::npos) << warm.start;
  }
}

TEST_P(DualGuesses, CompleteAnOptimalTrajectory) {
  int with = 0, without = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const testing::LinearQuadratic lq(seed, 4, {3, 2}, 8, -3, 3);
    std::vector<testing::Added> cuts = testing::cuts(lq);
    // Ipopt stalls at the tip of a cone, where its smooth surface has no curvature.
    if (std::string_view(GetParam()) == "ipopt") cuts.pop_back();
    const ShootingProblem problem = testing::with_constraints(*lq.problem, cuts);
    SolverOptions options = small_violations();
    const SolveResult cold = solve(problem, GetParam(), options, problem.create_trajectory());
    ASSERT_EQ(cold.status, SolveStatus::converged) << cold.message;
    without += solve(problem, GetParam(), options, cold.trajectory).iterations;
    options.multipliers = multipliers_of(cold);
    with += solve(problem, GetParam(), options, cold.trajectory).iterations;
  }
  EXPECT_LE(with, 6);
  EXPECT_LT(with, without);
}

TEST_P(DualGuesses, RejectsAnotherShape) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -3, 3);
  const ShootingProblem problem = testing::with_constraints(*lq.problem, testing::cuts(lq));
  SolverOptions options;
  auto guess = std::make_shared<DualGuess>();
  guess->constraints = Eigen::VectorXd::Zero(problem.constraint_rows() + 1);
  options.multipliers = guess;
  EXPECT_THROW(solve(problem, GetParam(), options, problem.create_trajectory()),
               std::invalid_argument);
}

TEST_P(DualGuesses, MayOmitOptionalPartsButNotChangeShapes) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 2, -3, 3);
  std::vector<testing::Added> cuts = testing::cuts(lq);
  if (std::string_view(GetParam()) == "ipopt") cuts.pop_back();
  const ShootingProblem problem = testing::with_constraints(*lq.problem, cuts);
  DualGuess whole;
  whole.constraints = Eigen::VectorXd::Zero(problem.constraint_rows());
  whole.costates = Eigen::MatrixXd::Zero(4, 5);
  for (const int nu : {3, 3, 2, 2}) whole.control_gradient.push_back(Eigen::VectorXd::Zero(nu));
  const auto fits = [&](const DualGuess& guess) {
    SolverOptions options;
    options.max_iterations = 0;
    options.multipliers = std::make_shared<DualGuess>(guess);
    try {
      solve(problem, GetParam(), options, problem.create_trajectory());
    } catch (const std::invalid_argument&) {
      return false;
    }
    return true;
  };
  EXPECT_TRUE(fits(whole));
  DualGuess other = whole;
  other.costates.resize(0, 0);
  other.control_gradient.clear();
  EXPECT_TRUE(fits(other));
  other.costates = Eigen::MatrixXd::Zero(5, 5);
  EXPECT_FALSE(fits(other));
  other.costates = Eigen::MatrixXd::Zero(4, 4);
  EXPECT_FALSE(fits(other));
  other = whole;
  other.control_gradient.pop_back();
  EXPECT_FALSE(fits(other));
  for (const int k : {0, 3}) {
    other = whole;
    other.control_gradient[k].resize(4);
    EXPECT_FALSE(fits(other)) << k;
  }
  other = whole;
  other.constraints.resize(1);
  EXPECT_FALSE(fits(other));
}

INSTANTIATE_TEST_SUITE_P(Solvers, DualGuesses, ::testing::Values("altro", "proxddp", "ipopt"));

}  // namespace
}  // namespace conddp
