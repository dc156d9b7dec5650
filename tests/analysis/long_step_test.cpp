// Steps that are too long for an explicit integrator, of one that decays by itself.
#include "analysis/findings/long_step.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// Two knots of x' = −rate x + u with this integrator, the second one `ratio` times as long.
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

TEST(LongStep, IsOneOnWhichAMotionGrowsThatDecays) {
  const auto found = step_of(decay(50, Integrator::rk4, 0.05, 2));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->knot, 1);
  EXPECT_NEAR(found->rate, 50, 1e-12);
  EXPECT_NEAR(found->growth, 1 - 5 + 25.0 / 2 - 125.0 / 6 + 625.0 / 24, 1e-12);
  EXPECT_NEAR(found->longest, 0.04, 1e-12);
}

TEST(LongStep, DependsOnTheRule) {
  EXPECT_TRUE(step_of(decay(50, Integrator::explicit_euler, 0.07)));  // |1 − 3.5|
  EXPECT_FALSE(step_of(decay(50, Integrator::explicit_euler, 0.05)));
  EXPECT_FALSE(step_of(decay(50, Integrator::rk4, 0.05)));
}

TEST(LongStep, LetsGrowWhatGrowsInTime) { EXPECT_FALSE(step_of(decay(-50, Integrator::rk4, 0.1))); }

TEST(LongStep, IsNoneWhereDerivativesAreNotFinite) {
  EXPECT_FALSE(step_of(decay(std::numeric_limits<double>::quiet_NaN(), Integrator::rk4, 0.1)));
}

}  // namespace
}  // namespace conddp
