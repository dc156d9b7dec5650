// A policy rolled out through the linear model, compared with dense matrices.
#include "solvers/riccati/linear_rollout.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "support/dense_horizon.hpp"

namespace conddp::testing {
namespace {

/// A random model with gaps, a policy, and an iterate with nonzero controls.
struct RolledOut {
  RolledOut()
      : lq(1, 3, {1, 2}, 4, -0.6, 0.5),
        problem(*lq.problem),
        bounds(problem),
        linearization(problem),
        gaps(problem),
        trajectory(random_guess(problem, 3)),
        feedback(problem),
        rollout(problem, bounds) {
    RandomNumbers random(2);
    randomize(problem, random, linearization);
    gaps.set(linearization, true);
    bounds.clamp(trajectory);
    for (int k = 0; k < problem.knots(); ++k) {
      for (double& number : feedback.k[k]) number = random.uniform(-1, 1);
      for (double& number : feedback.K[k].reshaped()) number = random.uniform(-1, 1);
    }
  }

  LinearQuadratic lq;
  const ShootingProblem& problem;
  ControlBounds bounds;
  Linearization linearization;
  Gaps gaps;
  Trajectory trajectory;
  Feedback feedback;
  LinearRollout rollout;
};

TEST(LinearRollout, FollowsModelStatesAndBoundedPolicyControls) {
  RolledOut at;
  const DenseHorizon dense(at.linearization, true);
  for (const bool clamp : {false, true}) {
    at.rollout.run(at.linearization, at.trajectory, at.gaps, at.feedback, clamp);
    const Eigen::VectorXd z = dense.stack(at.rollout.z());
    EXPECT_LT((dense.E * z - dense.e).norm(), 1e-10);
    EXPECT_NEAR(at.rollout.slope(), dense.g.dot(z), 1e-10);
    EXPECT_NEAR(at.rollout.curvature(at.linearization), z.dot(dense.H * z), 1e-10);
    int below = 0, above = 0;
    for (int k = 0; k < at.problem.knots(); ++k) {
      const Eigen::VectorXd wanted = at.feedback.k[k] + at.feedback.K[k] * at.rollout.dx(k);
      for (int i = 0; i < wanted.size(); ++i) {
        const double u = at.trajectory.u(k)[i], lower = at.bounds.lower(k)[i],
                     upper = at.bounds.upper(k)[i];
        below += u + wanted[i] < lower;
        above += u + wanted[i] > upper;
        const double expected = clamp ? std::clamp(u + wanted[i], lower, upper) - u : wanted[i];
        EXPECT_NEAR(at.rollout.du(k)[i], expected, 1e-12) << k << ' ' << i;
      }
    }
    EXPECT_GT(below, 0);
    EXPECT_GT(above, 0);
    Trajectory moved = at.trajectory;
    at.rollout.apply(at.problem.manifold(), 1, moved);
    for (int k = 0; k <= at.problem.knots(); ++k) {
      EXPECT_LT((moved.x(k) - at.trajectory.x(k) - at.rollout.dx(k)).norm(), 1e-12) << k;
      if (k == at.problem.knots()) continue;
      EXPECT_LT((moved.u(k) - at.trajectory.u(k) - at.rollout.du(k)).norm(), 1e-12) << k;
    }
    for (KnotLinearization& knot : at.linearization.knots) knot.gradient *= 2;
    at.rollout.measure_slope(at.linearization);
    EXPECT_NEAR(at.rollout.slope(), 2 * dense.g.dot(z), 1e-10);
    for (KnotLinearization& knot : at.linearization.knots) knot.gradient /= 2;
  }
}

TEST(LinearRollout, RespondsToGapsThroughGainsOnly) {
  RolledOut at;
  const DenseHorizon dense(at.linearization, true);
  at.rollout.respond(at.linearization, at.gaps, at.feedback);
  const Eigen::VectorXd z = dense.stack(at.rollout.z());
  EXPECT_LT((dense.E * z - dense.e).norm(), 1e-10);
  EXPECT_GT(z.norm(), 0.1);
  for (int k = 0; k < at.problem.knots(); ++k)
    EXPECT_LT((at.rollout.du(k) - at.feedback.K[k] * at.rollout.dx(k)).norm(), 1e-12) << k;
}

// Sparse Hessians from costs, and full ones of several lanes.
TEST(LinearRollout, HasCurvatureOfAllHessianEntries) {
  const ShootingProblem problem = quadrotor_move();
  const ControlBounds bounds(problem);
  const Trajectory trajectory = constant_controls(problem, 1.2);
  Linearization linearization(problem);
  Evaluator(problem).differentiate(trajectory, linearization);
  ASSERT_EQ(linearization.knots[0].hessian.fill(), HessianFill::lasting);
  RandomNumbers random(5);
  Feedback feedback(problem);
  for (int k = 0; k < problem.knots(); ++k) {
    for (double& number : feedback.k[k]) number = random.uniform(-0.1, 0.1);
    for (double& number : feedback.K[k].reshaped()) number = random.uniform(-0.01, 0.01);
  }
  Gaps gaps(problem);
  gaps.set(linearization, false);
  LinearRollout rollout(problem, bounds);
  rollout.run(linearization, trajectory, gaps, feedback, false);
  for (const bool full : {false, true}) {
    double wanted = 0;
    for (std::size_t k = 0; k < linearization.knots.size(); ++k) {
      KnotHessian& hessian = linearization.knots[k].hessian;
      if (full) {
        Eigen::MatrixXd& H = hessian.change();
        for (double& number : H.reshaped()) number = random.uniform(0, 1);
        H = (H + H.transpose()).eval();
      }
      const Eigen::VectorXd& z = rollout.z()[k];
      wanted += z.dot(hessian() * z);
    }
    EXPECT_NEAR(rollout.curvature(linearization), wanted, 1e-11 * std::abs(wanted)) << full;
  }
}

}  // namespace
}  // namespace conddp::testing
