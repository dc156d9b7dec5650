// Discretization errors along motions whose steps are known analytically.
#include "analysis/certificate/coarse_grid.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// x' = rate · x + u from x = 1 with steps dt; constant controls hold the state of each node.
struct Case {
  Case(double rate, Integrator integrator, double dt, int knots, double unit = 1)
      : problem(problem_of(rate, integrator, dt, knots, unit)),
        motion(problem.create_trajectory()) {}

  static ShootingProblem problem_of(double rate, Integrator integrator, double dt, int knots,
                                    double unit) {
    const Eigen::MatrixXd A = Eigen::MatrixXd::Constant(1, 1, rate);
    const auto system = linear_system(A, Eigen::MatrixXd::Ones(1, 1), Eigen::VectorXd::Zero(1),
                                      SystemKind::first_order);
    return {{unit},
            {{.name = "run",
              .model = std::make_shared<KnotModel>(system, integrator),
              .dt = std::vector<double>(knots, dt),
              .cost_scale = std::vector<double>(knots, 1.0)}},
            {.name = "end",
             .model = std::make_shared<KnotModel>(system, Integrator::none),
             .dt = {0},
             .cost_scale = {1}}};
  }

  /// Multiplies the state by a factor at each step, without controls.
  void multiply(double factor) {
    for (int k = 0; k < problem.knots(); ++k) motion.x(k + 1) = factor * motion.x(k);
  }
  std::vector<Eigen::MatrixXd> gains(double gain) const {
    return std::vector<Eigen::MatrixXd>(problem.knots(), Eigen::MatrixXd::Constant(1, 1, gain));
  }

  ShootingProblem problem;
  Trajectory motion;
};

// Euler multiplies by 1 − 0.2 per step and two half steps by 0.9²: an error of 0.01, half of which
// the half steps reveal.
TEST(GridError, AddsUpErrorsOfSteps) {
  Case decay(-2, Integrator::explicit_euler, 0.1, 2);
  decay.multiply(0.8);
  const auto error = grid_error(decay.problem, decay.motion);
  ASSERT_TRUE(error);
  EXPECT_NEAR(error->sum, 2 * 0.01 * (1 + 0.8), 1e-12);
  EXPECT_NEAR(error->way, 1 - 0.64, 1e-12);
  EXPECT_NEAR(error->relative, error->sum / error->way, 1e-12);
  EXPECT_EQ(error->knot, 0);
  EXPECT_EQ(error->entry, 0);
}

TEST(GridError, IsIndependentOfUnits) {
  for (const double unit : {1e-9, 1e9}) {
    Case one(-2, Integrator::rk2, 0.1, 5), other(-2, Integrator::rk2, 0.1, 5, unit);
    one.multiply(0.82);
    other.multiply(0.82);
    const double relative = grid_error(one.problem, one.motion)->relative;
    EXPECT_NEAR(grid_error(other.problem, other.motion)->relative, relative, 1e-9 * relative);
  }
}

TEST(GridError, FallsWithOtherRulesAndShorterSteps) {
  for (const int knots : {5, 20}) {  // 20: more than the worst steps
    Case decay(-2, Integrator::explicit_euler, 0.1, knots);
    decay.multiply(0.8);
    const GridError own = *grid_error(decay.problem, decay.motion);
    const auto error = [&](std::optional<Integrator> rule, int parts) {
      return *error_by(decay.problem, decay.motion, own, rule, parts);
    };
    EXPECT_NEAR(error(std::nullopt, 1), own.relative, 1e-12);
    EXPECT_LT(error(std::nullopt, 4), own.relative / 3);
    EXPECT_LT(error(Integrator::rk4, 1), 1e-3 * own.relative);
    EXPECT_LT(error(Integrator::radau5, 1), 1e-4 * own.relative);
  }
}

TEST(CoarseGrid, IsFoundIfStepsLeaveTheMotion) {
  const double z = -10, factor = 1 + z + z * z / 2 + z * z * z / 6 + z * z * z * z / 24;
  Case stiff(-1000, Integrator::rk4, 0.01, 4);
  stiff.multiply(factor);
  const auto found = coarse_grid(stiff.problem, stiff.motion, stiff.gains(0));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->knot, 3);
  Case fine(-1, Integrator::rk4, 0.01, 4);
  fine.multiply(std::exp(-0.01));
  EXPECT_FALSE(coarse_grid(fine.problem, fine.motion, fine.gains(0)));
}

// Step errors accumulate to a fifth of the motion; feedback removes them.
TEST(CoarseGrid, IsNotFoundIfFeedbackHoldsTheMotion) {
  Case growth(1, Integrator::explicit_euler, 0.3, 4);
  growth.multiply(1.3);
  EXPECT_TRUE(coarse_grid(growth.problem, growth.motion, growth.gains(0)));
  EXPECT_FALSE(coarse_grid(growth.problem, growth.motion, growth.gains(-4)));
}

TEST(CoarseGrid, IsNotFoundAtRest) {
  Case rest(-1000, Integrator::rk4, 0.01, 4);
  for (int k = 0; k <= 4; ++k) rest.motion.x(k).setZero();
  EXPECT_FALSE(coarse_grid(rest.problem, rest.motion, rest.gains(0)));
}

}  // namespace
}  // namespace conddp
