// Interior points in the sweep, against an independent method and against other solvers.
#include <algorithm>

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

/// The cuts that are not cones, soft by their distance if a weight is given.
std::vector<Added> rows(const LinearQuadratic& lq, double weight) {
  std::vector<Added> list = testing::cuts(lq);
  std::erase_if(list,
                [](const Added& cut) { return cut.kind == ConstraintKind::second_order_cone; });
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
      const ShootingProblem problem = testing::with_constraints(*lq.problem, rows(lq, weight));
      const Eigen::VectorXd expected =
          testing::dense_optimum(problem, testing::make_dense(lq, problem, -kBound, kBound));
      const SolveResult result =
          solve(problem, "ipddp", testing::tight_options(), problem.create_trajectory());
      EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
      EXPECT_LT((controls_of(result.trajectory) - expected).cwiseAbs().maxCoeff(), 1e-6)
          << seed << ", weight " << weight;
      EXPECT_LE(result.iterations, 40) << seed << ", weight " << weight;
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

}  // namespace
}  // namespace conddp
