#include "analysis/certificate/reduced_gradient.hpp"

#include <gtest/gtest.h>

#include "analysis/certificate/gains_check.hpp"
#include "analysis/certificate/node_hessians.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// One step x⁺ = x + u from the origin with ½ (x⁺ − 1)² + ½ u²: u = ½ is the best, u = −½ x off
/// the origin, and Q_uu = 2.
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

// From u to the best ½ the cost falls by (u − ½)², as its second derivative is 2.
TEST(RiccatiPolicy, TheExpectedDecreaseOfAQuadraticCostIsItsDecrease) {
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

// At its lower bound a control is stationary where the cost rises with it, and the other way round.
TEST(ProjectedGradient, ABoundTakesTheSignThatDescentWouldCrossItWith) {
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
  // Outside of its bounds the multiplier is not complementary.
  EXPECT_EQ(projected(-1.5, 3).product, 1.5);
  EXPECT_EQ(projected(1.5, -3).product, 1.5);
}

// A control that is at its bound as it comes, without a multiplier, is free or held as a sweep has
// it.
TEST(GainsCheck, ABoundThatDoesNotPushMayHoldOrNot) {
  const ShootingProblem problem = one_step(-1, 0.5);
  SolutionClaims claims(problem);
  claims.trajectory = simulated(problem, 0.5);
  claims.gain_regularization = 0;
  const auto feedback_holds = [&](double gain) {
    claims.gains[0].setConstant(gain);
    const auto checks =
        check_gains(problem, claims, derivatives_of(problem, claims.trajectory),
                    gauss_newton_hessians(problem, claims.trajectory), Eigen::MatrixXd::Zero(1, 1));
    EXPECT_EQ(checks.size(), 2u);
    return checks.at(0).holds;
  };
  EXPECT_TRUE(feedback_holds(-0.5));
  EXPECT_TRUE(feedback_holds(0));
  EXPECT_FALSE(feedback_holds(-0.4));
}

}  // namespace
}  // namespace conddp
