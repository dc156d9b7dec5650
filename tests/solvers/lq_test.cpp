#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/linear_quadratic.hpp"

namespace conddp {
namespace {

using testing::kFree;
using testing::LinearQuadratic;

double distance(const Trajectory& a, const Trajectory& b) {
  double worst = (a.x(a.knots()) - b.x(a.knots())).lpNorm<Eigen::Infinity>();
  for (int k = 0; k < a.knots(); ++k) {
    worst = std::max(worst, (a.x(k) - b.x(k)).lpNorm<Eigen::Infinity>());
    worst = std::max(worst, (a.u(k) - b.u(k)).lpNorm<Eigen::Infinity>());
  }
  return worst;
}

TEST(LinearQuadratic, EverySolverReachesDenseOptimumWithRiccatiGains) {
  for (unsigned seed = 1; seed <= 12; ++seed) {
    // Some have inactive bounds.
    const double bound = seed % 2 == 0 ? kFree : 1e4;
    const LinearQuadratic lq(seed, 2 + seed % 5, {3, 1, 2}, 4, -bound, bound);
    const Trajectory optimum = lq.dense_optimum();
    const auto gains = lq.riccati_gains();
    const Trajectory guess = testing::random_guess(*lq.problem, 100 + seed);
    for (const SolverInfo& solver : solvers()) {
      if (unsupported(solver, *lq.problem)) continue;
      const SolveResult result = solve(*lq.problem, solver, {}, guess);
      SCOPED_TRACE(fmt::format("{} seed {}: {}", solver.name, seed, result.message));
      EXPECT_EQ(result.status, SolveStatus::converged);
      // An interior-point method also reacts to inactive bounds.
      if (!solver.complementarity) {
        EXPECT_EQ(result.iterations, 1);
        ASSERT_EQ(result.log.size(), 2u);
        EXPECT_EQ(result.log[1].step, 1);
        EXPECT_EQ(result.log[1].trials, 1);
        EXPECT_EQ(result.log[1].regularization, 0);
      }
      EXPECT_LE(distance(result.trajectory, optimum), 1e-9);
      EXPECT_NEAR(result.cost, lq.cost(optimum), 1e-9 * std::abs(lq.cost(optimum)));
      ASSERT_TRUE(result.feedback_regularization);
      EXPECT_EQ(*result.feedback_regularization, 0);
      for (int k = 0; k < lq.N(); ++k) {
        EXPECT_LE((result.feedback.K[k] - gains[k]).lpNorm<Eigen::Infinity>(), 1e-9);
        EXPECT_LE(result.feedback.k[k].lpNorm<Eigen::Infinity>(), 1e-8);
      }
    }
  }
}

// More controls than a lane holds: stages are factorized in blocks.
TEST(LinearQuadratic, ManyControlsHaveRiccatiGainsToo) {
  const LinearQuadratic lq(3, 4, {9, 17}, 2, -kFree, kFree);
  const Trajectory optimum = lq.dense_optimum();
  const auto gains = lq.riccati_gains();
  for (const SolverInfo& solver : solvers()) {
    if (unsupported(solver, *lq.problem) || solver.name == "ipopt") continue;
    SCOPED_TRACE(solver.name);
    const SolveResult result =
        solve(*lq.problem, solver, {}, testing::random_guess(*lq.problem, 8));
    EXPECT_EQ(result.status, SolveStatus::converged);
    EXPECT_EQ(result.iterations, 1);
    EXPECT_EQ(result.log.back().regularization, 0);
    EXPECT_LE(distance(result.trajectory, optimum), 1e-8);
    for (int k = 0; k < lq.N(); ++k)
      EXPECT_LE((result.feedback.K[k] - gains[k]).lpNorm<Eigen::Infinity>(), 1e-8);
  }
}

TEST(LinearQuadratic, CostatesAreTheDenseMultipliers) {
  const LinearQuadratic lq(5, 4, {2, 3}, 6, -kFree, kFree);
  Eigen::MatrixXd multipliers;
  lq.dense_optimum(&multipliers);
  for (const SolverInfo& solver : solvers()) {
    const SolveResult result =
        solve(*lq.problem, solver, {}, testing::random_guess(*lq.problem, 7));
    EXPECT_LE((result.costates - multipliers).rightCols(lq.N()).lpNorm<Eigen::Infinity>(), 1e-8)
        << solver.name;
  }
}

// Pitfall 7: without V_x ← V_x + V_xx gap, the first sweep from open gaps is not Newton's.
TEST(LinearQuadratic, OpenGapsCostNoIteration) {
  const LinearQuadratic lq(3, 5, {2, 2}, 5, -kFree, kFree);
  const Trajectory guess = testing::random_guess(*lq.problem, 9, 10);
  for (const char* name : {"fddp", "box_fddp"}) {
    const SolveResult result = solve(*lq.problem, name, {}, guess);
    EXPECT_EQ(result.iterations, 1) << name;
    EXPECT_GT(result.log[0].gap, 1);
    EXPECT_LE(result.residuals.gap, 1e-12);
    EXPECT_LE(distance(result.trajectory, lq.dense_optimum()), 1e-9);
  }
}

TEST(LinearQuadratic, GuessAtTheOptimumConvergesWithoutAStep) {
  const LinearQuadratic lq(4, 3, {2, 1}, 5, -kFree, kFree);
  const Trajectory optimum = lq.dense_optimum();
  for (const SolverInfo& solver : solvers()) {
    const SolveResult result = solve(*lq.problem, solver, {}, optimum);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver.name;
    EXPECT_EQ(result.iterations, 0) << solver.name;
  }
}

/// The box-constrained optimum by projected gradient steps on the condensed problem, followed by
/// the linear system of the free entries.
Eigen::VectorXd projected_gradient(const Eigen::MatrixXd& H, const Eigen::VectorXd& g, double low,
                                   double up) {
  const int n = static_cast<int>(g.size());
  const double L = H.operatorNorm();
  Eigen::VectorXd x = Eigen::VectorXd::Zero(n), y = x, before = x;
  double t = 1;
  for (int i = 0; i < 200000; ++i) {
    before = x;
    x = (y - (H * y + g) / L).cwiseMax(low).cwiseMin(up);
    if ((x - before).lpNorm<Eigen::Infinity>() < 1e-14) break;
    if ((y - x).dot(x - before) > 0) t = 1;  // restart
    const double next = 0.5 * (1 + std::sqrt(1 + 4 * t * t));
    y = x + (t - 1) / next * (x - before);
    t = next;
  }
  std::vector<int> free;
  for (int i = 0; i < n; ++i) {
    if (x[i] > low && x[i] < up) free.push_back(i);
  }
  const Eigen::VectorXd residual = -(H * x + g);
  const Eigen::MatrixXd Hff = H(free, free);
  const Eigen::VectorXd correction = Hff.ldlt().solve(residual(free).eval());
  for (std::size_t a = 0; a < free.size(); ++a) x[free[a]] += correction[a];
  return x;
}

TEST(BoxLinearQuadratic, BoxSolversReachDenseOptimumWithinBounds) {
  int all_clamped = 0, all_controls = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const double bound = 0.3;
    const LinearQuadratic lq(seed, 4, {3, 2}, 6, -bound, bound);
    Eigen::MatrixXd H;
    Eigen::VectorXd g;
    lq.condense(H, g);
    const Eigen::VectorXd U = projected_gradient(H, g, -bound, bound);
    const Trajectory guess = testing::random_guess(*lq.problem, seed);
    for (const char* name : {"box_ddp", "box_fddp"}) {
      const SolveResult result = solve(*lq.problem, name, {}, guess);
      SCOPED_TRACE(fmt::format("{} seed {}: {}", name, seed, result.message));
      EXPECT_EQ(result.status, SolveStatus::converged);
      EXPECT_EQ(result.residuals.constraint, 0);
      int at = 0, clamped = 0;
      for (int k = 0; k < lq.N(); ++k) {
        for (int i = 0; i < lq.problem->nu(k); ++i, ++at) {
          const double u = result.trajectory.u(k)[i];
          EXPECT_NEAR(u, U[at], 1e-6);
          EXPECT_LE(std::abs(u), bound);
          if (std::abs(u) < bound) continue;
          ++clamped;
          // Pitfall 2: no feedback through a clamped control.
          EXPECT_EQ(result.feedback.K[k].row(i).lpNorm<Eigen::Infinity>(), 0);
        }
      }
      EXPECT_GT(clamped, 3);
      all_clamped += clamped;
      all_controls += at;
    }
  }
  EXPECT_LT(all_clamped, 0.9 * all_controls);
}

TEST(BoxLinearQuadratic, TightToleranceGivesTheDenseOptimumToRounding) {
  const double bound = 0.3;
  const LinearQuadratic lq(2, 4, {3, 2}, 6, -bound, bound);
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  lq.condense(H, g);
  const Eigen::VectorXd U = projected_gradient(H, g, -bound, bound);
  for (const char* name : {"box_ddp", "box_fddp"}) {
    SolverOptions options;
    options.tolerances.stationarity = 1e-11;
    const SolveResult result =
        solve(*lq.problem, name, options, testing::random_guess(*lq.problem, 1));
    EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
    int at = 0;
    for (int k = 0; k < lq.N(); ++k) {
      for (double u : result.trajectory.u(k)) EXPECT_NEAR(u, U[at++], 1e-8);
    }
  }
}

// Pitfall 1: clamping the controls does not replace the bounded stage problem.
TEST(BoxLinearQuadratic, ClippingEndsShortOfTheOptimumSomewhere) {
  int short_of_it = 0;
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 6, -0.3, 0.3);
    const Trajectory guess = testing::random_guess(*lq.problem, seed);
    const SolveResult box = solve(*lq.problem, "box_ddp", {}, guess);
    const SolveResult clip = solve(*lq.problem, "ilqr_clip", {.max_iterations = 100}, guess);
    EXPECT_EQ(clip.residuals.constraint, 0);
    EXPECT_GE(clip.cost, box.cost - 1e-9);
    const bool honest = (clip.status == SolveStatus::converged) ==
                        (clip.residuals.stationarity <= 1e-6 && clip.residuals.gap <= 1e-9);
    EXPECT_TRUE(honest);
    if (clip.status != SolveStatus::converged) ++short_of_it;
  }
  EXPECT_GE(short_of_it, 5);
}

}  // namespace
}  // namespace conddp
