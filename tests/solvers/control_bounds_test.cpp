// Bounds of two knots by hand: saturated controls, violations, and pushing gradients.
#include "solvers/common/control_bounds.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/constrained_problems.hpp"

namespace conddp::testing {
namespace {

/// Three coordinates with one control each at two knots: |u| ≤ (1, 2, ∞) at the first, and
/// 0.25 ≤ u₀ ≤ 4 and u₁ ≤ 3 at the second.
ShootingProblem two_knots() {
  const auto system = linear_system(Eigen::Matrix3d::Identity(), Eigen::Matrix3d::Identity(),
                                    Eigen::Vector3d::Zero());
  auto first = std::make_shared<KnotModel>(system, Integrator::discrete);
  auto second = std::make_shared<KnotModel>(system, Integrator::discrete);
  first->set_control_bounds({-1, -2, -kFree}, {1, 2, kFree});
  second->set_control_bounds({0.25, -kFree, -kFree}, {4, 3, kFree});
  std::vector<Phase> phases;
  for (const auto& model : {first, second})
    phases.push_back({.name = "phase", .model = model, .dt = {1}, .cost_scale = {1}});
  return ShootingProblem({0, 0, 0}, std::move(phases),
                         {.name = "end",
                          .model = std::make_shared<KnotModel>(system, Integrator::none),
                          .dt = {0},
                          .cost_scale = {1}});
}

struct BoundsOfTwoKnots : ::testing::Test {
  ShootingProblem problem = two_knots();
  ControlBounds bounds{problem};
  Trajectory trajectory = problem.create_trajectory();
};

TEST_F(BoundsOfTwoKnots, ConcatenateTheBoundsOfBothModels) {
  EXPECT_EQ(bounds.knots(), 2);
  EXPECT_EQ(bounds.size(), 6);
  EXPECT_EQ(bounds.offset(1), 3);
  EXPECT_EQ(bounds.lower(0), Eigen::Vector3d(-1, -2, -kFree));
  EXPECT_EQ(bounds.upper(1), Eigen::Vector3d(4, 3, kFree));
}

TEST_F(BoundsOfTwoKnots, ClampValuesOutside) {
  trajectory.u(0) << 1.5, -3, 100;
  trajectory.u(1) << 0.25, 2, -100;
  EXPECT_EQ(bounds.clamp(trajectory), 2);
  EXPECT_EQ(trajectory.u(0), Eigen::Vector3d(1, -2, 100));
  EXPECT_EQ(trajectory.u(1), Eigen::Vector3d(0.25, 2, -100));
  trajectory.u(1) << 0, 7, 0;
  EXPECT_EQ(bounds.clamp(trajectory), 2);
  EXPECT_EQ(trajectory.u(1), Eigen::Vector3d(0.25, 3, 0));
  EXPECT_EQ(bounds.clamp(trajectory), 0);
}

TEST_F(BoundsOfTwoKnots, ViolationIsLargestAtTheLargestDistance) {
  trajectory.u(1) << 0.25, 3, 100;
  const Extremum none = bounds.violation(trajectory);
  EXPECT_EQ(none.value, 0);
  EXPECT_EQ(none.knot, -1);
  trajectory.u(0) << 1.5, 0, 0;
  EXPECT_EQ(bounds.violation(trajectory).value, 0.5);
  EXPECT_EQ(bounds.violation(trajectory).knot, 0);
  trajectory.u(1) << -0.5, 3.5, 0;
  EXPECT_EQ(bounds.violation(trajectory).value, 0.75);
  EXPECT_EQ(bounds.violation(trajectory).knot, 1);
}

TEST_F(BoundsOfTwoKnots, AreMetToRounding) {
  EXPECT_TRUE(bounds.at_lower(0, 0, -1));
  EXPECT_TRUE(bounds.at_lower(0, 0, -1 + 1e-15));
  EXPECT_FALSE(bounds.at_lower(0, 0, -1 + 1e-13));
  EXPECT_TRUE(bounds.at_lower(0, 0, -5));
  EXPECT_FALSE(bounds.at_upper(0, 0, -1));
  EXPECT_TRUE(bounds.at_upper(0, 1, 2 - 2e-15));
  EXPECT_FALSE(bounds.at_upper(0, 1, 2 - 1e-13));
  EXPECT_TRUE(bounds.at_upper(1, 1, 3.5));
  EXPECT_FALSE(bounds.at_bound(1, 2, 1e300));
  EXPECT_TRUE(bounds.at_bound(1, 0, 0.25));
  EXPECT_TRUE(bounds.at_bound(1, 0, 4));
  EXPECT_FALSE(bounds.at_bound(1, 0, 2));
}

TEST_F(BoundsOfTwoKnots, BalanceAGradientPushingAgainstThem) {
  trajectory.u(0) << -1, 2, 0;
  trajectory.u(1) << 0.25, 3, 0;
  Eigen::VectorXd gradient(6);
  gradient << 9, -8, 0.5, 7, -6, 0.25;  // pushes all saturated controls against their bounds
  EXPECT_EQ(bounds.projected_norm(gradient, trajectory).value, 0.5);
  EXPECT_EQ(bounds.projected_norm(gradient, trajectory).knot, 0);
  gradient[3] = -0.75;  // away from the lower bound
  EXPECT_EQ(bounds.projected_norm(gradient, trajectory).value, 0.75);
  EXPECT_EQ(bounds.projected_norm(gradient, trajectory).knot, 1);
  gradient[1] = 1.5;  // away from the upper bound
  EXPECT_EQ(bounds.projected_norm(gradient, trajectory).value, 1.5);
  EXPECT_EQ(bounds.projected_norm(gradient, trajectory).knot, 0);
  for (int i = 0; i < 6; ++i) {
    Eigen::VectorXd missing = gradient;
    missing[i] = std::nan("");
    EXPECT_TRUE(std::isnan(bounds.projected_norm(missing, trajectory).value)) << i;
    EXPECT_EQ(bounds.projected_norm(missing, trajectory).knot, i / 3);
  }
  gradient.setZero();
  EXPECT_EQ(bounds.projected_norm(gradient, trajectory).knot, -1);
}

TEST(LargestViolation, CoversBoundsAndHardConstraintsOnly) {
  const ShootingProblem free = two_knots();
  Added box{.name = "box",
            .residual = state_residual(free.manifold()),
            .reference = {0, 0, 0},
            .lower = {-1, -1, -1},
            .upper = {1, 2, 3},
            .first = 0,
            .last = 2};
  Added soft = box;
  soft.softness = Softness::l1;
  soft.weight = 1;
  const ShootingProblem problem = with_constraints(free, {box, soft});
  const ControlBounds bounds(problem);
  Trajectory trajectory = problem.create_trajectory();
  trajectory.u(0) << 1.25, 0, 0;
  trajectory.u(1) << 0.25, 0, 0;
  Eigen::VectorXd values = Eigen::VectorXd::Zero(problem.constraint_rows());
  EXPECT_EQ(largest_violation(problem, bounds, trajectory, values).value, 0.25);
  EXPECT_EQ(largest_violation(problem, bounds, trajectory, values).knot, 0);
  ASSERT_EQ(values.size(), 18);
  // Each node has three hard rows, then three soft rows, which count as costs.
  values[3] = values[12 + 4] = 9;
  values[6 + 2] = 6.5;
  EXPECT_EQ(largest_violation(problem, bounds, trajectory, values).value, 3.5);
  EXPECT_EQ(largest_violation(problem, bounds, trajectory, values).knot, 1);
  values[12 + 1] = -8;
  EXPECT_EQ(largest_violation(problem, bounds, trajectory, values).value, 7);
  EXPECT_EQ(largest_violation(problem, bounds, trajectory, values).knot, 2);
  values[2] = std::nan("");
  EXPECT_TRUE(std::isnan(largest_violation(problem, bounds, trajectory, values).value));
}

}  // namespace
}  // namespace conddp::testing
