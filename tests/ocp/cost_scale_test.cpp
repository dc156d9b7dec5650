#include "ocp/problem/cost_scale.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "ocp/problem/by_name.hpp"
#include "ocp/residuals/residuals.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// A mass for two knots of 0.5 s with costs ½ effort · u², terminal ½ rest · Σ wᵢ xᵢ², and soft ·
/// |u| if soft is positive.
ShootingProblem weighted(double effort, double rest, std::vector<double> components = {},
                         double soft = 0) {
  auto running = std::make_shared<KnotModel>(double_integrator(1), Integrator::rk4);
  running->add_cost("effort", control_residual(2, 1), {});
  std::vector<double> numbers{0, effort};
  if (soft > 0) {
    running->add_constraint(
        make_constraint("soft", control_residual(2, 1), ConstraintKind::bounds, 1, Softness::l1));
    numbers.insert(numbers.end(), {0, 0, 0, 1, soft});
  }
  auto end = std::make_shared<KnotModel>(double_integrator(1), Integrator::none);
  Activation activation;
  activation.weights = std::move(components);
  end->add_cost("rest", state_residual(end->manifold()), activation);
  Phase phase{.name = "go", .model = running, .dt = {0.5, 0.5}, .cost_scale = {0.5, 0.5}};
  for (int k = 0; k < 2; ++k)
    phase.parameters.insert(phase.parameters.end(), numbers.begin(), numbers.end());
  return ShootingProblem(
      {1, 0}, {std::move(phase)},
      {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}, .parameters = {0, 0, rest}});
}

TEST(CostScale, IsOneForWeightsOfUsualSize) {
  EXPECT_EQ(cost_scale(weighted(1, 1)), 1);
  EXPECT_EQ(cost_scale(weighted(2e-5, 1e4)), 1);
  EXPECT_EQ(cost_scale(weighted(4e-5, 4e-5)), 1);
  EXPECT_EQ(cost_scale(weighted(0, 100)), 1);
  EXPECT_EQ(cost_scale(weighted(0, 0)), 1) << "without costs";
  EXPECT_EQ(cost_scale(weighted(1e-13, 1)), 1) << "a negligible weight";
}

TEST(CostScale, BringsMedianWeightToTheUsualOne) {
  EXPECT_EQ(cost_scale(weighted(0x1p-19, 0x1p-20)), 0x1p15);
  EXPECT_EQ(cost_scale(weighted(0x1p-15, 0x1p-24)), 0x1p15);
  EXPECT_EQ(cost_scale(weighted(0x1p9, 0x1p8)), 0x1p-13);
  EXPECT_EQ(cost_scale(weighted(0, 1e-9, {0, 1e-3})), std::exp2(std::round(-5 - std::log2(1e-12))));
  EXPECT_EQ(cost_scale(weighted(0, 0x1p-30, {}, 0x1p-29)), 0x1p25) << "a soft constraint";
}

TEST(LeastCost, FollowsTheLeastWeight) {
  // A knot lasts half a second, so half of the effort weight counts.
  EXPECT_DOUBLE_EQ(least_cost(weighted(2, 1e3)), 1e-12);
  EXPECT_DOUBLE_EQ(least_cost(weighted(2e-3, 1e3)), 1e-15);
  EXPECT_DOUBLE_EQ(least_cost(weighted(2e-3, 1e14)), 1e-10);
  EXPECT_DOUBLE_EQ(least_cost(weighted(5, 7)), 1e-12) << "large weights alone";
  EXPECT_TRUE(std::isinf(least_cost(weighted(0, 0))));
}

TEST(ScaledCosts, ScaleByTheFactorAndKeepTheRest) {
  const ShootingProblem problem = weighted(3, 5, {1, 2}, 0.7), twice = scale_costs(problem, 2);
  Trajectory trajectory = problem.create_trajectory();
  trajectory.u(0)[0] = 1;
  const auto costs = cost_by_name(problem, NodeValues(problem, trajectory));
  const auto scaled = cost_by_name(twice, NodeValues(twice, trajectory));
  ASSERT_EQ(costs.size(), 3u);
  for (std::size_t i = 0; i < costs.size(); ++i) {
    EXPECT_GT(costs[i].second, 0);
    EXPECT_EQ(scaled[i].second, 2 * costs[i].second) << costs[i].first;
  }
  EXPECT_EQ(twice.times(), problem.times());
  EXPECT_EQ(twice.initial_state(), problem.initial_state());
  ASSERT_EQ(twice.constraints().size(), 2u);
  EXPECT_EQ(twice.constraints()[0].limit, 2 * problem.constraints()[0].limit);
}

}  // namespace
}  // namespace conddp
