// Complementary control pairs with known optima: each knot has a wish for a pair 0 ≤ u₁ ⊥ u₂ ≥ 0
// and must give up one of the two.
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/pair_wishes.hpp"

namespace conddp::testing {
namespace {

TEST(Pairs, EveryRelaxationGivesUpOneWish) {
  const std::vector<Eigen::Vector2d> wishes = {{1, 3}, {2, 0.5}, {-1, 1}, {4, -2}};
  const ShootingProblem problem = wishes_for_pairs(wishes);
  for (const PairRelaxation way : {PairRelaxation::elementwise, PairRelaxation::fischer_burmeister,
                                   PairRelaxation::penalty, PairRelaxation::inner_product}) {
    SolverOptions options;
    options.complementarity.relaxation = way;
    const SolveResult result = solve(problem, "ipopt", options, problem.create_trajectory());
    ASSERT_EQ(result.status, SolveStatus::converged)
        << static_cast<int>(way) << ": " << result.message;
    double cost = 0;
    for (int k = 0; k < problem.knots(); ++k) {
      const Eigen::Vector2d u = result.trajectory.u(k);
      EXPECT_LE(std::abs(u.minCoeff()), 1e-6) << static_cast<int>(way) << " knot " << k;
      Eigen::Index kept = 0;
      u.maxCoeff(&kept);
      EXPECT_NEAR(u[kept], wishes[k][kept], 1e-5) << static_cast<int>(way) << " knot " << k;
      cost += 0.5 * (u - wishes[k]).squaredNorm();
    }
    EXPECT_NEAR(result.cost, cost, 1e-9);
    // The better choices: (0, 3), (2, 0), (0, 1), (4, 0).
    EXPECT_NEAR(result.cost, 0.5 * (1 + 0.25 + 1 + 4), 1e-5) << static_cast<int>(way);
    EXPECT_LE(result.residuals.stationarity, 1e-5);
    EXPECT_LE(result.residuals.constraint, 1e-6);
    // The requested relaxation succeeds from the first epsilon.
    EXPECT_EQ(result.log.back().fallbacks, 0);
    EXPECT_EQ(result.log.at(1).relaxation, options.complementarity.initial);
  }
}

TEST(Pairs, InteriorPointsGiveUpOneWish) {
  const std::vector<Eigen::Vector2d> wishes = {{1, 3}, {2, 0.5}, {-1, 1}, {4, -2}};
  const ShootingProblem problem = wishes_for_pairs(wishes);
  const SolveResult result = solve(problem, "ipddp", {}, problem.create_trajectory());
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  for (int k = 0; k < problem.knots(); ++k) {
    const Eigen::Vector2d u = result.trajectory.u(k);
    EXPECT_LE(std::abs(u.minCoeff()), 1e-12) << k;
    Eigen::Index kept = 0;
    u.maxCoeff(&kept);
    EXPECT_NEAR(u[kept], wishes[k][kept], 1e-9) << k;
  }
  EXPECT_NEAR(result.cost, 0.5 * (1 + 0.25 + 1 + 4), 1e-9);
  EXPECT_EQ(result.log.back().fallbacks, 0);
}

}  // namespace
}  // namespace conddp::testing
