#include "solvers/common/guess.hpp"

#include <gtest/gtest.h>

#include "support/small_problems.hpp"

namespace conddp::testing {
namespace {

TEST(Guess, MustHaveTheShapeOfTheProblem) {
  const ShootingProblem problem = unicycle_parking();
  const int N = problem.knots();
  EXPECT_NO_THROW(check_shape(problem, problem.create_trajectory()));
  const auto expect_misfit = [&](int nx, std::vector<int> nu) {
    EXPECT_THROW(check_shape(problem, Trajectory(nx, nu)), std::invalid_argument);
  };
  std::vector<int> nu(N, 2);
  expect_misfit(4, nu);
  nu.back() = 1;
  expect_misfit(3, nu);
  nu = std::vector<int>(N, 2);
  nu.front() = 3;
  expect_misfit(3, nu);
  expect_misfit(3, std::vector<int>(N + 1, 2));
  expect_misfit(3, std::vector<int>(N - 1, 2));
}

TEST(Guess, IsMovedToItsBoundsAndReported) {
  const ShootingProblem problem = unicycle_parking(1);
  const ControlBounds bounds(problem);
  Trajectory guess = problem.create_trajectory();
  std::string start = "cold";
  clamp_guess(bounds, guess, start);
  EXPECT_EQ(start, "cold");
  guess.u(3)[1] = 2;
  clamp_guess(bounds, guess, start);
  EXPECT_EQ(guess.u(3)[1], 1);
  EXPECT_EQ(start, "cold; 1 control entry moved to a bound");
  guess.u(3) << -2, 3;
  start.clear();
  clamp_guess(bounds, guess, start);
  EXPECT_EQ(start, "; 2 control entries moved to a bound");
}

TEST(Guess, BeginsAtTheInitialStateWithUnitQuaternions) {
  const ShootingProblem problem = quadrotor_move();
  const Trajectory exact = problem.create_trajectory();
  Trajectory guess = exact;
  std::string start;
  correct_states(problem, guess, start);
  EXPECT_EQ(start, "");
  guess.x(0)[1] += 0.25;
  guess.x(0)[2] -= 0.5;
  guess.x(2).segment(3, 4) << 0, 0.6 * 1.0005, 0, 0.8 * 1.0005;
  correct_states(problem, guess, start);
  EXPECT_EQ(start, "; x_0 corrected by 0.5");
  EXPECT_EQ(guess.x(0), exact.x(0));
  EXPECT_NEAR(guess.x(2)[4], 0.6, 1e-14);
  EXPECT_NEAR(guess.x(2)[6], 0.8, 1e-14);
  EXPECT_EQ(guess.x(2).head(3), exact.x(2).head(3));
  guess.x(problem.knots()).segment(3, 4) << 0, 0, 0, 3;
  try {
    correct_states(problem, guess, start);
    ADD_FAILURE() << "a quaternion of length 3";
  } catch (const std::invalid_argument& error) {
    EXPECT_EQ(std::string(error.what()),
              "state 50 of the guess: a quaternion is far from unit length");
  }
  guess.x(problem.knots()).setConstant(std::numeric_limits<double>::quiet_NaN());
  EXPECT_NO_THROW(correct_states(problem, guess, start)) << "solvers tell where it is not finite";
}

TEST(Guess, IsPerturbedOnManifoldExceptTheFirstState) {
  const ShootingProblem problem = quadrotor_move();
  const Trajectory guess = constant_controls(problem, 1.3);
  const Trajectory same = perturb_guess(problem, guess, 0, 5);
  const Trajectory near = perturb_guess(problem, guess, 0.1, 5);
  const Trajectory far = perturb_guess(problem, guess, 0.2, 5);
  const Trajectory other = perturb_guess(problem, guess, 0.1, 6);
  const Trajectory again = perturb_guess(problem, guess, 0.1, 5);
  EXPECT_EQ(near.x(0), guess.x(0));
  Eigen::VectorXd dx(12), twice(12), changed(12);
  double squares = 0;
  int numbers = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    EXPECT_LT((same.x(k) - guess.x(k)).norm(), 1e-14);
    EXPECT_EQ(near.x(k), again.x(k));
    problem.manifold().difference(guess.x(k).data(), near.x(k).data(), dx.data());
    problem.manifold().difference(guess.x(k).data(), far.x(k).data(), twice.data());
    EXPECT_LT((twice - 2 * dx).norm(), 1e-12) << k;
    if (k > 0) {
      EXPECT_NE(near.x(k), other.x(k));
      squares += dx.squaredNorm();
      numbers += 12;
    }
    if (k == problem.knots()) break;
    const Eigen::VectorXd du = near.u(k) - guess.u(k);
    EXPECT_LT((far.u(k) - guess.u(k) - 2 * du).norm(), 1e-14) << k;
    EXPECT_EQ(same.u(k), guess.u(k));
    squares += du.squaredNorm();
    numbers += 4;
  }
  EXPECT_NEAR(std::sqrt(squares / numbers), 0.1, 0.01);  // 800 normal samples
}

}  // namespace
}  // namespace conddp::testing
