// Interior points in the sweep, against an independent method and against other solvers.
#include <algorithm>
#include <limits>

#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

using testing::Added;
using testing::controls_of;
using testing::LinearQuadratic;

constexpr double kBound = 3;

/// Rows, norms and cones that exclude an optimum, soft by their distance if a weight is given.
std::vector<Added> cuts(const LinearQuadratic& lq, double weight) {
  std::vector<Added> list = testing::cuts(lq);
  for (Added& cut : list) {
    cut.softness = weight > 0 ? Softness::l1 : Softness::hard;
    cut.weight = weight;
  }
  return list;
}

TEST(InteriorPoints, ConvexOptimaMatchAnIndependentMethod) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const double weight : {0.0, 0.1, 0.5}) {
      const LinearQuadratic lq(seed, 4, {3, 2}, 8, -kBound, kBound);
      const ShootingProblem problem = testing::with_constraints(*lq.problem, cuts(lq, weight));
      const Eigen::VectorXd expected =
          testing::dense_optimum(problem, testing::make_dense(lq, problem, -kBound, kBound));
      const SolveResult result =
          solve(problem, "ipddp", testing::tight_options(), problem.create_trajectory());
      EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
      EXPECT_LT((controls_of(result.trajectory) - expected).cwiseAbs().maxCoeff(), 1e-6)
          << seed << ", weight " << weight;
    }
}

TEST(InteriorPoints, RowsAndBoundsMeetAnotherSolversOptimum) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    if (name == "three obstacles") continue;  // one of many optima
    const Trajectory guess = testing::constant_controls(problem, control);
    const SolveResult own = solve(problem, "ipddp", {}, guess);
    ASSERT_EQ(own.status, SolveStatus::converged) << name << ": " << own.message;
    EXPECT_NEAR(own.cost, cost, 1e-4 * cost) << name;
  }
}

TEST(InteriorPoints, EqualBoundsHoldAControl) {
  const ShootingProblem problem =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {0, 0},
                                {{1, 0}, {1, 1}, {0.1}, {1, 1}}, 0.5, 0.5);
  const SolveResult result = solve(problem, "ipddp", {}, problem.create_trajectory());
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  for (int k = 0; k < problem.knots(); ++k) EXPECT_NEAR(result.trajectory.u(k)[0], 0.5, 1e-12) << k;
}

TEST(InteriorPoints, AnswerWithTheGuessWithoutIterations) {
  const ShootingProblem problem =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {0, 0},
                                {{1, 0}, {1, 1}, {0.1}, {1, 1}}, 0, 1);
  SolverOptions options;
  options.max_iterations = 0;
  const Trajectory guess = problem.create_trajectory();
  const SolveResult result = find_solver("ipddp")->run(problem, options, guess);
  EXPECT_EQ(result.status, SolveStatus::max_iterations) << result.message;
  for (int k = 0; k < problem.knots(); ++k) EXPECT_EQ(result.trajectory.u(k)[0], 0) << k;
}

TEST(InteriorPoints, GuessesThatAreNotFiniteEndAsDiverged) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const ShootingProblem problem =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {0, 0},
                                {{nan, 0}, {1, 1}, {0.1}, {1, 1}}, -1, 1);
  const SolveResult result = find_solver("ipddp")->run(problem, {}, problem.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::diverged) << result.message;
  EXPECT_EQ(result.log.size(), 1);
}

TEST(InteriorPoints, UseTheHessianThatIsAsked) {
  const ShootingProblem problem = testing::cartpole_swing_up(3);
  for (const auto& [choice, exact] :
       {std::pair(HessianChoice::gauss_newton, false), std::pair(HessianChoice::exact, true)}) {
    SolverOptions options;
    options.hessian = choice;
    options.max_iterations = 30;
    Trajectory guess = testing::constant_controls(problem, 0.01);
    ASSERT_EQ(Evaluator(problem).simulate(guess), -1);
    const SolveResult result = find_solver("ipddp")->run(problem, options, guess);
    bool used = false;
    for (const IterationRecord& row : result.log) used |= row.exact_hessian;
    EXPECT_EQ(used, exact);
  }
}

}  // namespace
}  // namespace conddp
