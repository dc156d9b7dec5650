// One solver iteration, compared with a textbook Riccati recursion, rollouts, and search in plain
// arithmetic.
#include <algorithm>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/plain_pendulum.hpp"
#include "support/random_numbers.hpp"

namespace conddp::testing {
namespace {

using Complex = std::complex<double>;

/// One DDP iteration on a pendulum without bounds.
struct PlainIteration {
  /// From states and controls with contracting gaps, and costates without gains.
  PlainIteration(const PlainPendulum& pendulum, const Trajectory& t, bool exact)
      : plain(pendulum), from(t) {
    const int N = plain.knots;
    lambda.resize(N + 1);
    lambda[N] = plain.end_gradient(x(N));
    for (int k = N - 1; k >= 0; --k)
      lambda[k] = plain.stage_gradient(x(k), u(k)).head<2>() +
                  plain.jacobian(x(k)).leftCols<2>().transpose() * lambda[k + 1];
    Eigen::Vector2d Vx = lambda[N];
    Eigen::Matrix2d Vxx = plain.qf.asDiagonal();
    k_.resize(N);
    K_.resize(N);
    for (int k = N - 1; k >= 0; --k) {
      const auto J = plain.jacobian(x(k));
      const Eigen::Vector2d gap = plain.next<double>(x(k), u(k)) - x(k + 1);
      gaps.push_back(gap);
      gap_norm += gap.lpNorm<1>();
      stationarity = std::max(stationarity, std::abs(plain.stage_gradient(x(k), u(k))[2] +
                                                     J.col(2).dot(lambda[k + 1])));
      Eigen::Matrix3d H = plain.stage_hessian();
      if (exact) H(0, 0) += plain.curvature(x(k), lambda[k + 1]);
      const Eigen::Vector3d Qz =
          plain.stage_gradient(x(k), u(k)) + J.transpose() * (Vx + Vxx * gap);
      const Eigen::Matrix3d Qzz = H + J.transpose() * Vxx * J;
      convex = convex && Qzz(2, 2) > 0;
      k_[k] = -Qz[2] / Qzz(2, 2);
      K_[k] = -Qzz.row(2).head<2>() / Qzz(2, 2);
      Vx = Qz.head<2>() - Qzz.col(2).head<2>() * Qz[2] / Qzz(2, 2);
      Vxx = Qzz.topLeftCorner<2, 2>() - Qzz.col(2).head<2>() * Qzz.row(2).head<2>() / Qzz(2, 2);
    }
    std::reverse(gaps.begin(), gaps.end());
    Eigen::Vector2d dx(0, 0);
    for (int k = 0; k < N; ++k) {
      step.emplace_back(dx[0], dx[1], k_[k] + K_[k].dot(dx));
      curvature += step[k].dot(plain.stage_hessian() * step[k]);
      dx = plain.jacobian(x(k)) * step[k] + gaps[k];
    }
    step.emplace_back(dx[0], dx[1], 0);
    curvature += dx.dot(plain.qf.cwiseProduct(dx));
    const Complex h(0, 1e-30);
    Trajectory unused;
    slope = rollout<Complex>(h, unused).imag() / h.imag();
    cost = rollout<double>(0, unused);
  }
  Eigen::Vector2d x(int k) const { return from.x(k); }
  double u(int k) const { return from.u(k)[0]; }

  /// J of u + α k + K δx, with gaps that shrink by 1 − α.
  template <class S>
  S rollout(S alpha, Trajectory& to) const {
    to = from;
    PlainPendulum::State<S> at = x(0).cast<S>();
    S sum(0);
    for (int k = 0; k < plain.knots; ++k) {
      const PlainPendulum::State<S> away = at - x(k).cast<S>();
      const S control = u(k) + alpha * k_[k] + K_[k][0] * away[0] + K_[k][1] * away[1];
      sum += plain.stage_cost<S>(at, control);
      at = plain.next<S>(at, control) + (alpha - S(1)) * gaps[k].cast<S>();
      if constexpr (std::is_same_v<S, double>) {
        to.u(k)[0] = control;
        to.x(k + 1) = at;
      }
    }
    return sum + plain.end_cost<S>(at);
  }
  /// J and gaps of the linear model's step, times α.
  double linear(double alpha, double& left, Trajectory& to) const {
    to = from;
    const int N = plain.knots;
    for (int k = 0; k <= N; ++k) {
      to.x(k) += alpha * step[k].head<2>();
      if (k < N) to.u(k)[0] += alpha * step[k][2];
    }
    double sum = plain.end_cost<double>(to.x(N));
    left = 0;
    for (int k = 0; k < N; ++k) {
      sum += plain.stage_cost<double>(to.x(k), to.u(k)[0]);
      left += (plain.next<double>(to.x(k), to.u(k)[0]) - to.x(k + 1)).lpNorm<1>();
    }
    return sum;
  }

  const PlainPendulum& plain;
  Trajectory from;
  std::vector<Eigen::Vector2d> lambda, gaps;
  std::vector<double> k_;
  std::vector<Eigen::RowVector2d> K_;
  std::vector<Eigen::Vector3d> step;  ///< δx and δu of the linear model
  bool convex = true;                 ///< every stage has a minimum
  double cost = 0, slope = 0, curvature = 0, gap_norm = 0, stationarity = 0;
};

void expect_equal(const Trajectory& found, const Trajectory& expected) {
  for (int k = 0; k <= expected.knots(); ++k)
    EXPECT_LT((found.x(k) - expected.x(k)).norm(), 1e-10) << k;
  for (int k = 0; k < expected.knots(); ++k)
    EXPECT_NEAR(found.u(k)[0], expected.u(k)[0], 1e-10) << k;
}

// If a stage has no minimum with exact Hessians, cost Hessians replace them. Armijo's rule on J
// accepts the full step if it gains a third of the promised slope; otherwise it takes the longest
// step whose half is not better. Two lanes compare fewer halves.
TEST(OneIteration, DdpMatchesRecursionWithExactHessiansAndRollout) {
  if (kLaneWidth < 4) GTEST_SKIP() << "of processors without AVX";
  int full = 0, shorter = 0, exact_ones = 0, others = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    PlainPendulum plain;
    plain.dt = seed % 2 == 0 ? 0.1 : 0.25;
    const ShootingProblem problem = plain.problem();
    RandomNumbers random(seed);
    Trajectory guess = problem.create_trajectory();
    for (int k = 0; k < 5; ++k) {
      guess.u(k)[0] = random.uniform(-6, 6);
      guess.x(k + 1) = plain.next<double>(guess.x(k), guess.u(k)[0]);
    }
    const bool exact = PlainIteration(plain, guess, true).convex;
    (exact ? exact_ones : others)++;
    const PlainIteration at(plain, guess, exact);
    Trajectory expected;
    double alpha = 1;
    const auto gain = [&](double length) { return at.cost - at.rollout<double>(length, expected); };
    if (gain(1) < -at.slope / 3)
      while (gain(alpha) < -1e-4 * alpha * at.slope ||
             (alpha > 0.125 && gain(alpha / 2) > gain(alpha)))
        alpha /= 2;
    (alpha == 1 ? full : shorter)++;
    const double gained = gain(alpha);

    const SolveResult result = solve(problem, "ddp", {.max_iterations = 1}, guess);
    ASSERT_EQ(result.log.size(), 2u);
    EXPECT_NEAR(result.log[0].cost, at.cost, 1e-12 * at.cost);
    EXPECT_NEAR(result.log[0].stationarity, at.stationarity, 1e-11 * at.stationarity);
    EXPECT_EQ(result.log[1].step, alpha);
    EXPECT_EQ(result.log[1].exact_hessian, exact);
    EXPECT_EQ(result.log[1].regularization, 0);
    EXPECT_NEAR(result.log[1].expected_decrease, -alpha * at.slope, 1e-10 * at.cost);
    EXPECT_NEAR(result.log[1].actual_decrease, gained, 1e-11 * at.cost);
    EXPECT_NEAR(result.cost, at.cost - gained, 1e-11 * at.cost);
    expect_equal(result.trajectory, expected);
    // Steps down to a fifth need no regularization of the next sweep; shorter ones do.
    const SolveResult next = solve(problem, "ddp", {.max_iterations = 2}, guess);
    if (next.log.size() == 3 && next.log[2].sweeps == 1) {
      EXPECT_EQ(next.log[2].regularization > 0, alpha <= 0.2) << alpha;
    }
  }
  EXPECT_GE(full, 3);
  EXPECT_GE(shorter, 3);
  EXPECT_GE(exact_ones, 3);
  EXPECT_GE(others, 3);
}

// From open gaps: the better of rollout and linear step on J + ν Σ‖gap‖₁. The weight lets 0.65 of
// the gap term pay for the step.
TEST(OneIteration, FddpMatchesRecursionWithGaussNewtonAndMerit) {
  int full = 0, shorter = 0, straight = 0, costly = 0;
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    PlainPendulum plain;
    plain.dt = seed % 2 == 0 ? 0.1 : 0.5;
    const ShootingProblem problem = plain.problem();
    // Far from the optimum, or so near that closing gaps costs more than the step gains.
    const bool far = seed % 3 != 0;
    Trajectory guess = random_guess(problem, seed, far ? 0.5 + 3 * (seed % 5) : 0.2);
    if (!far) {
      const Trajectory optimum = solve(problem, "ddp", {}, problem.create_trajectory()).trajectory;
      for (int k = 0; k <= 5; ++k) guess.x(k) += optimum.x(k);
      for (int k = 0; k < 5; ++k) guess.u(k) = optimum.u(k);
    }
    guess.x(0) = plain.start;
    const PlainIteration at(plain, guess, false);
    const double nu = std::max(at.slope + 0.5 * at.curvature, 0.0) / (0.65 * at.gap_norm);
    costly += nu > 0;
    const double merit = at.cost + nu * at.gap_norm, promise = nu * at.gap_norm - at.slope;
    Trajectory expected, other;
    double alpha = 2, gained = 0;
    do {
      alpha /= 2;
      gained = merit - at.rollout<double>(alpha, expected) - nu * (1 - alpha) * at.gap_norm;
      if (gained >= 0.6 * (alpha * promise - 0.5 * alpha * alpha * at.curvature)) continue;
      double left = 0;
      const double cost = at.linear(alpha, left, other);
      if (merit - cost - nu * left <= gained) continue;
      gained = merit - cost - nu * left;
      expected = other;
      straight += gained >= 1e-4 * alpha * promise;
    } while (gained < 1e-4 * alpha * promise);
    (alpha == 1 ? full : shorter)++;

    const SolveResult result = solve(problem, "fddp", {.max_iterations = 1}, guess);
    ASSERT_EQ(result.log.size(), 2u);
    EXPECT_NEAR(result.log[0].cost, at.cost, 1e-12 * at.cost);
    EXPECT_NEAR(result.log[0].stationarity, at.stationarity, 1e-11 * at.stationarity);
    EXPECT_EQ(result.log[1].step, alpha);
    EXPECT_FALSE(result.log[1].exact_hessian);
    EXPECT_NEAR(result.log[1].penalty, nu, 1e-10 * (1 + nu));
    EXPECT_NEAR(result.log[1].expected_decrease, alpha * promise, 1e-10 * merit);
    EXPECT_NEAR(result.log[1].actual_decrease, gained, 1e-10 * merit);
    expect_equal(result.trajectory, expected);
  }
  EXPECT_GE(full, 3);
  EXPECT_GE(shorter, 1);
  EXPECT_GE(straight, 1);
  EXPECT_GE(costly, 3);
}

}  // namespace
}  // namespace conddp::testing
