// Steps too long for an explicit integrator of a decaying system.
#include "analysis/findings/long_step.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/expression_systems.hpp"

namespace conddp {
namespace {

/// Two knots of x' = −rate x + u with this integrator; the second is `ratio` times as long.
ShootingProblem decay(double rate, Integrator integrator, double dt, double ratio = 1) {
  const Eigen::MatrixXd A = Eigen::MatrixXd::Constant(1, 1, -rate);
  const auto system = linear_system(A, Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Zero(1),
                                    SystemKind::first_order);
  const auto model = std::make_shared<KnotModel>(system, integrator);
  return {{0.0},
          {{.name = "decay", .model = model, .dt = {dt, ratio * dt}, .cost_scale = {1, 1}}},
          {.name = "end",
           .model = std::make_shared<KnotModel>(system, Integrator::none),
           .dt = {0},
           .cost_scale = {1}}};
}

std::optional<LongStep> step_of(const ShootingProblem& problem) {
  return long_step(problem, problem.create_trajectory());
}

TEST(LongStep, GrowsAMotionThatShouldDecay) {
  const auto found = step_of(decay(50, Integrator::rk4, 0.05, 2));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->knot, 1);
  EXPECT_NEAR(found->rate, 50, 1e-12);
  EXPECT_NEAR(found->growth, 1 - 5 + 25.0 / 2 - 125.0 / 6 + 625.0 / 24, 1e-12);
  EXPECT_NEAR(found->longest, 0.04, 1e-12);
}

TEST(LongStep, DependsOnTheRule) {
  EXPECT_TRUE(step_of(decay(50, Integrator::explicit_euler, 0.045)));  // |1 − 2.25|
  EXPECT_FALSE(step_of(decay(50, Integrator::explicit_euler, 0.035)));
  EXPECT_FALSE(step_of(decay(50, Integrator::rk4, 0.05)));
}

/// Two knots of q'' = −stiffness q − damping v + u with semi-implicit Euler.
ShootingProblem spring(double stiffness, double damping, double dt) {
  const auto system = expression_system(
      {.kind = SystemKind::second_order,
       .states = expression_numbers({"q"}),
       .velocities = expression_columns({"v"}),
       .controls = expression_columns({"u"}),
       .equations = {{"v", fmt::format("u - ({})*q - ({})*v", stiffness, damping)}}});
  const auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  return {{0.0, 0.0},
          {{.name = "swing", .model = model, .dt = {dt, dt}, .cost_scale = {1, 1}}},
          {.name = "end",
           .model = std::make_shared<KnotModel>(system, Integrator::none),
           .dt = {0},
           .cost_scale = {1}}};
}

// Semi-implicit Euler is stable for h² k < 4 − 2 h d.
TEST(LongStep, SemiImplicitEulerAlternates) {
  EXPECT_FALSE(step_of(spring(390, 0, 0.1)));
  EXPECT_FALSE(step_of(spring(190, 10, 0.1)));
  EXPECT_FALSE(step_of(spring(-1000, 0, 0.1)));  // unstable in continuous time too
  EXPECT_FALSE(step_of(spring(0, 19, 0.1)));
  const auto undamped = step_of(spring(410, 0, 0.1));
  ASSERT_TRUE(undamped);
  EXPECT_NEAR(undamped->rate, std::sqrt(410), 1e-9);
  EXPECT_NEAR(undamped->longest, 0.05, 1e-12);
  EXPECT_TRUE(step_of(spring(210, 10, 0.1)));
  const auto damped = step_of(spring(0, 50, 0.1));
  ASSERT_TRUE(damped);
  EXPECT_NEAR(damped->growth, 4, 1e-9);  // |1 − 5|
  EXPECT_NEAR(damped->longest, 0.025, 1e-12);
}

TEST(LongStep, NamesImplicitRule) {
  const ShootingProblem problem = decay(50, Integrator::rk4, 0.1);
  const auto found = long_step(problem, problem.create_trajectory());
  ASSERT_TRUE(found);
  EXPECT_NE(remedy_of(*found, problem).find("radau5"), std::string::npos);
}

TEST(LongStep, AllowsGrowthOfUnstableSystems) {
  EXPECT_FALSE(step_of(decay(-50, Integrator::rk4, 0.1)));
}

TEST(LongStep, IsNotFoundForNonFiniteDerivatives) {
  EXPECT_FALSE(step_of(decay(std::numeric_limits<double>::quiet_NaN(), Integrator::rk4, 0.1)));
}

}  // namespace
}  // namespace conddp
