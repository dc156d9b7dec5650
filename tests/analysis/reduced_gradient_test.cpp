#include "analysis/certificate/reduced_gradient.hpp"

#include <gtest/gtest.h>

#include "analysis/certificate/gains_check.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "analysis/derivatives/node_hessians.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// One step x⁺ = x + u from the origin with cost ½ (x⁺ − 1)² + ½ u²: the optimum is u = ½, the gain
/// is −½, and Q_uu = 2.
ShootingProblem one_step(double low = -testing::kFree, double up = testing::kFree) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  return testing::tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)),
                                   Integrator::discrete, 1, 1, {0}, {{1}, {0}, {1}, {1}, false},
                                   low, up);
}

Trajectory simulated(const ShootingProblem& problem, double control) {
  Trajectory trajectory = testing::constant_controls(problem, control);
  Evaluator(problem).simulate(trajectory);
  return trajectory;
}

std::vector<NodeDerivatives> derivatives_of(const ShootingProblem& problem,
                                            const Trajectory& trajectory) {
  return node_derivatives(problem, trajectory, Eigen::MatrixXd::Zero(1, 1));
}

// From u to the optimum ½, the cost falls by (u − ½)², since its second derivative is 2.
TEST(RiccatiPolicy, ExpectedDecreaseIsExactForQuadraticCosts) {
  const ShootingProblem problem = one_step();
  for (const double u : {0.0, 0.2, 2.0}) {
    const Trajectory trajectory = simulated(problem, u);
    const auto derivatives = derivatives_of(problem, trajectory);
    const RiccatiPolicy policy = riccati_policy(problem, trajectory, derivatives,
                                                gauss_newton_hessians(problem, trajectory));
    EXPECT_NEAR(policy.K[0](0, 0), -0.5, 1e-15);
    const AdjointPass pass = adjoint_pass(problem, derivatives, {}, policy.K);
    EXPECT_NEAR(pass.control[0][0], 2 * u - 1, 1e-15);
    EXPECT_NEAR(policy.decrease(pass.control), (u - 0.5) * (u - 0.5), 1e-15);
  }
}

// A control at its lower bound is stationary if the cost rises with it, and vice versa at the upper
// bound.
TEST(ProjectedGradient, BoundBlocksDescentAcrossItself) {
  const ShootingProblem problem = one_step(-1, 1);
  const auto projected = [&](double u, double gradient) {
    return project(problem, simulated(problem, u), {Eigen::VectorXd::Constant(1, gradient)});
  };
  EXPECT_EQ(projected(-1, 3).stationarity, 0);
  EXPECT_EQ(projected(-1, -3).stationarity, 3);
  EXPECT_EQ(projected(1, -3).stationarity, 0);
  EXPECT_EQ(projected(1, 3).stationarity, 3);
  EXPECT_EQ(projected(0, 3).stationarity, 3);
  EXPECT_EQ(projected(0, -3).stationarity, 3);
  // Outside the bounds, the multiplier is not complementary.
  EXPECT_EQ(projected(-1.5, 3).product, 1.5);
  EXPECT_EQ(projected(1.5, -3).product, 1.5);
}

// A value counts as at its bound within rounding, relative to the bound or to 1, or within the
// tolerance.
TEST(ProjectedGradient, BoundIsMetToRounding) {
  const ShootingProblem problem = one_step(-3, 3);
  const auto stationarity = [&](double u, double gradient, double tolerance) {
    return project(problem, simulated(problem, u), {Eigen::VectorXd::Constant(1, gradient)},
                   tolerance)
        .stationarity;
  };
  for (const double side : {-1.0, 1.0}) {
    const double push = -2 * side;
    EXPECT_EQ(stationarity(side * (3 - 2e-14), push, kBoundRounding), 0);
    EXPECT_EQ(stationarity(side * (3 - 1e-13), push, kBoundRounding), 2);
    EXPECT_EQ(stationarity(side * (3 - 2e-6), push, 1e-6), 0);
    EXPECT_EQ(stationarity(side * (3 - 4e-6), push, 1e-6), 2);
  }
  const ShootingProblem narrow = one_step(-0.5, 0.5);
  for (const double side : {-1.0, 1.0})
    EXPECT_EQ(project(narrow, simulated(narrow, side * (0.5 - 9e-7)),
                      {Eigen::VectorXd::Constant(1, -side)}, 1e-6)
                  .stationarity,
              0);
}

// A control at its bound without a multiplier may be free or held, as the sweep decides.
TEST(GainsCheck, InactiveBoundMayBeHeldOrFree) {
  const ShootingProblem problem = one_step(-1, 0.5);
  SolutionClaims claims(problem);
  claims.trajectory = simulated(problem, 0.5);
  claims.gain_regularization = 0;
  const auto feedback_holds = [&](double gain) {
    claims.gains[0].setConstant(gain);
    const auto derivatives = derivatives_of(problem, claims.trajectory);
    const auto hessians = gauss_newton_hessians(problem, claims.trajectory);
    const auto checks =
        check_gains(problem, claims, derivatives, hessians, Eigen::MatrixXd::Zero(1, 1));
    EXPECT_EQ(checks.size(), 2u);
    return checks.at(0).holds;
  };
  EXPECT_TRUE(feedback_holds(-0.5));
  EXPECT_TRUE(feedback_holds(0));
  EXPECT_FALSE(feedback_holds(-0.4));
}

// Two terms of ∇_u L change by 1e-13 relative, and so does the costate in one of them. For one sign
// of f_u, all changes add up.
TEST(AdjointPass, RoundingSumsAllTermsOfTheGradient) {
  const ShootingProblem problem = one_step();
  const Eigen::VectorXd none(0);
  for (const double effort : {0.5, 8.0}) {
    double most = 0;
    for (const double slope : {-3.0, 3.0}) {
      std::vector<NodeDerivatives> derivatives(2);
      derivatives[0] = {Eigen::Vector2d(0, effort), Eigen::MatrixXd(0, 2),
                        Eigen::RowVector2d(1, slope)};
      derivatives[1] = {Eigen::VectorXd::Constant(1, 2), Eigen::MatrixXd(0, 1), {}};
      const AdjointPass pass = adjoint_pass(problem, derivatives, none, {});
      EXPECT_EQ(pass.control[0][0], effort + 2 * slope);
      most = std::max(most, pass.rounding);
    }
    EXPECT_NEAR(most, kAdjointRounding * (effort + 2 * 3 * 2), 1e-3 * kAdjointRounding);
  }
}

}  // namespace
}  // namespace conddp
