// Segment sweeps of a horizon match the sequential step for any number of segments.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/stages/stage_solver.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/conic_problems.hpp"
#include "support/constrained_problems.hpp"
#include "support/segment_comparison.hpp"

namespace conddp {
namespace {

using testing::LinearQuadratic;
using testing::SegmentedIterate;

TEST(SegmentSweep, SegmentsCoverHorizonWithDoubleLast) {
  EXPECT_EQ(SegmentSweep::split(60, 2), (std::vector<int>{0, 20, 60}));
  EXPECT_EQ(SegmentSweep::split(50, 4), (std::vector<int>{0, 10, 20, 30, 50}));
  EXPECT_EQ(SegmentSweep::split(17, 3), (std::vector<int>{0, 4, 8, 17}));
  EXPECT_EQ(SegmentSweep::split(3, 3), (std::vector<int>{0, 1, 2, 3}));
  for (int knots = 1; knots < 30; ++knots)
    for (int segments = 1; segments <= knots; ++segments) {
      const std::vector<int> first = SegmentSweep::split(knots, segments);
      ASSERT_EQ(static_cast<int>(first.size()), segments + 1);
      EXPECT_EQ(first.back(), knots);
      for (int i = 0; i < segments; ++i)
        EXPECT_LT(first[i], first[i + 1]) << knots << ' ' << segments;
    }
}

TEST(SegmentSweep, LinearQuadraticStepMatchesDenseSystem) {
  for (unsigned seed = 1; seed <= 8; ++seed) {
    const LinearQuadratic lq(seed, 2 + seed % 5, {3, 1, 2}, 4, -testing::kFree, testing::kFree, 1);
    Eigen::MatrixXd multipliers;
    const Trajectory optimum = lq.dense_optimum(&multipliers);
    Trajectory guess = testing::random_guess(*lq.problem, 100 + seed);
    guess.x(0) = lq.x0;
    for (const int segments : {2, 3, 5, 12}) {
      SCOPED_TRACE(fmt::format("seed {}, {} segments", seed, segments));
      SegmentedIterate iterate(*lq.problem, guess, {.count = segments});
      ASSERT_TRUE(iterate.begin());
      iterate.sweep_another_cost();
      iterate.sweep();
      for (int k = 0; k < lq.N(); ++k) {
        const Eigen::VectorXd& z = iterate.step()[k];
        EXPECT_LT((guess.x(k) + z.head(lq.nx) - optimum.x(k)).cwiseAbs().maxCoeff(), 1e-9);
        EXPECT_LT((guess.u(k) + z.tail(z.size() - lq.nx) - optimum.u(k)).cwiseAbs().maxCoeff(),
                  1e-9);
        EXPECT_LT((iterate.costates[k] - multipliers.col(k + 1)).cwiseAbs().maxCoeff(), 1e-8);
      }
    }
  }
}

// From the second sweep on, segment ends use the values of this cost.
TEST(SegmentSweep, StagesMatchTheSequentialSweep) {
  for (unsigned seed = 1; seed <= 4; ++seed) {
    const LinearQuadratic lq(seed, 3, {3, 1, 2}, 4, -testing::kFree, testing::kFree, 1);
    const Trajectory guess = testing::random_guess(*lq.problem, 100 + seed);
    SegmentedIterate whole(*lq.problem, guess, {}), parts(*lq.problem, guess, {.count = 4});
    for (SegmentedIterate* iterate : {&whole, &parts}) {
      ASSERT_TRUE(iterate->begin());
      iterate->sweep();
      iterate->sweep();
    }
    for (int k = 0; k < lq.N(); ++k) {
      ASSERT_EQ(parts.Quu(k).rows(), whole.Quu(k).rows()) << k;
      EXPECT_LT((parts.Quu(k) - whole.Quu(k)).norm(), 1e-8 * whole.Quu(k).norm()) << k;
    }
  }
}

TEST(SegmentSweep, StepsMatchTheSequentialSweep) {
  // Open gaps on SE(3), an impulse, active bounds, unstable motions.
  const struct {
    const char* name;
    double u;
    ShootingProblem problem;
  } cases[] = {{"acrobot", 0.01, testing::acrobot_swing_up()},
               {"pendulum", 0.01, testing::pendulum_swing_up(1)},
               {"cartpole, limited", 0.01, testing::cartpole_swing_up(3)},
               {"quadrotor", 1.3, testing::quadrotor_move()},
               {"quadrotor, limited", 1.3, testing::quadrotor_move(0.5, 2)},
               {"landing, limited", 0.01, testing::landing(60)}};
  for (const auto& [name, u, problem] : cases) {
    SCOPED_TRACE(name);
    Trajectory guess = testing::constant_controls(problem, u);
    testing::expect_equal_by_segments(problem, guess);
    Eigen::VectorXd delta(problem.ndx());
    for (int k = 1; k <= problem.knots(); ++k) {
      for (int i = 0; i < delta.size(); ++i) delta[i] = 0.1 * std::sin(k * (i + 1.0));
      const Eigen::VectorXd from = guess.x(k);
      problem.manifold().integrate(from.data(), delta.data(), guess.x(k).data());
    }
    testing::expect_equal_by_segments(problem, guess);
  }
}

TEST(SegmentSweep, StepsMatchWithConstraints) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    SCOPED_TRACE(name);
    testing::expect_equal_by_segments(problem, testing::constant_controls(problem, control));
  }
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const testing::ConicLinearQuadratic conic(seed, testing::middle_size());
    testing::expect_equal_by_segments(*conic.problem, testing::random_guess(*conic.problem, seed));
  }
}

/// Sweeps a problem of twelve knots twice, the second time with `change` in the Hessian of a node's
/// last rows and columns. Returns the knot that then has no minimum.
int bad_knot(const LinearQuadratic& lq, int segments, int node, const Eigen::MatrixXd& change) {
  const Trajectory guess = testing::random_guess(*lq.problem, 1);
  const ControlBounds bounds(*lq.problem);
  Linearization linearization(*lq.problem);
  Evaluator(*lq.problem).differentiate(guess, linearization);
  Gaps gaps(*lq.problem);
  gaps.set(linearization, true);
  BackwardSweep sweep(*lq.problem, bounds, {.count = segments});
  const auto stages = box_stage(*lq.problem, segments);
  Feedback feedback(*lq.problem);
  EXPECT_EQ(sweep.run(linearization, guess, gaps, {}, *stages, feedback), -1);
  Eigen::MatrixXd& hessian = linearization.knots[node].hessian.change();
  hessian.bottomRightCorner(change.rows(), change.cols()) += change;
  return sweep.run(linearization, guess, gaps, {}, *stages, feedback);
}

TEST(SegmentSweep, NamesStageWithoutMinimumLikeSequentialSweep) {
  const LinearQuadratic lq(3, 4, {2}, 12, -testing::kFree, testing::kFree, 1);
  for (const int knot : {2, 10})
    for (const int segments : {1, 3})
      EXPECT_EQ(bad_knot(lq, segments, knot, -1e3 * Eigen::MatrixXd::Identity(2, 2)), knot);
}

// Later segments may leave the first one without a minimum, even though each of its stages has one
// with the value of the previous sweep.
TEST(SegmentSweep, NamesStageLosingItsMinimumToLaterSegments) {
  const LinearQuadratic lq(5, 3, {2}, 12, -testing::kFree, testing::kFree, 1);
  Eigen::MatrixXd change = Eigen::MatrixXd::Zero(5, 5);
  change.topLeftCorner(3, 3).diagonal().setConstant(-1e3);
  const int first_of_last_leg = SegmentSweep::split(12, 2)[1];
  for (const int segments : {1, 2, 4})
    EXPECT_EQ(bad_knot(lq, segments, first_of_last_leg, change), first_of_last_leg - 1) << segments;
}

TEST(SegmentSweep, BitsAreIndependentOfThreadCount) {
  const ShootingProblem problem = testing::quadrotor_move(0.5, 2);
  const Trajectory guess = testing::constant_controls(problem, 1.3);
  for (const int segments : {2, 5}) {
    SegmentedIterate one(problem, guess, {segments, 1}), two(problem, guess, {segments, 2});
    for (SegmentedIterate* iterate : {&one, &two}) {
      ASSERT_TRUE(iterate->begin());
      iterate->sweep_another_cost();
      iterate->sweep();
    }
    EXPECT_EQ(one.step(), two.step());
    EXPECT_EQ(one.costates, two.costates);
    EXPECT_EQ(one.feedback.K, two.feedback.K);
  }
}

/// Largest gain difference of two answers, relative to the largest gain.
double gain_difference(const SolveResult& a, const SolveResult& b) {
  double off = 0, largest = 0;
  for (std::size_t k = 0; k < a.feedback.K.size(); ++k) {
    if (a.feedback.K[k].size() == 0) continue;
    off = std::max(off, (a.feedback.K[k] - b.feedback.K[k]).cwiseAbs().maxCoeff());
    largest = std::max(largest, b.feedback.K[k].cwiseAbs().maxCoeff());
  }
  return off / largest;
}

TEST(ProxddpByLegs, AnswersAndGainsMatchOneSegment) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    const Trajectory guess = testing::constant_controls(problem, control);
    SolverOptions options;
    options.tolerances.stationarity = options.tolerances.constraint = 1e-7;
    const SolveResult one = solve(problem, "proxddp", options, guess);
    ASSERT_EQ(one.status, SolveStatus::converged) << name << ": " << one.message;
    for (const int segments : {2, 3, 5}) {
      SCOPED_TRACE(fmt::format("{}, {} segments", name, segments));
      options.segments = segments;
      const SolveResult several = solve(problem, "proxddp", options, guess);
      EXPECT_EQ(several.status, SolveStatus::converged) << several.message;
      EXPECT_NEAR(several.cost, one.cost, 1e-7 * std::abs(one.cost));
      EXPECT_LT(gain_difference(several, one), 1e-4);
      ASSERT_TRUE(several.feedback_regularization);
      EXPECT_EQ(several.feedback_regularization, one.feedback_regularization);
    }
  }
}

TEST(ProxddpByLegs, ThreadsChangeNoBit) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    const Trajectory guess = testing::constant_controls(problem, control);
    for (const int segments : {2, 3}) {
      const auto run = [&](int threads) {
        SolverOptions options;
        options.max_iterations = 60;
        options.threads = threads;
        options.segments = segments;
        return solve(problem, "proxddp", options, guess);
      };
      const SolveResult one = run(1), two = run(2);
      ASSERT_EQ(one.log.size(), two.log.size()) << name;
      EXPECT_EQ(one.cost, two.cost) << name;
      EXPECT_EQ(one.costates, two.costates) << name;
      EXPECT_EQ(one.feedback.K, two.feedback.K) << name;
      for (int k = 0; k < problem.knots(); ++k)
        EXPECT_TRUE(one.trajectory.u(k) == two.trajectory.u(k)) << name;
    }
  }
}

TEST(ProxddpByLegs, RejectsOtherSolversAndTooManySegments) {
  const ShootingProblem problem = testing::unicycle_parking();
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  for (const SolverInfo& solver : solvers())
    EXPECT_EQ(unsupported_segments(solver, problem, 2).has_value(), solver.name != "proxddp")
        << solver.name;
  for (const SolverInfo& solver : solvers())
    EXPECT_FALSE(unsupported_segments(solver, problem, 1)) << solver.name;
  const SolverInfo& proxddp = *find_solver("proxddp");
  EXPECT_FALSE(unsupported_segments(proxddp, problem, problem.knots()));
  EXPECT_TRUE(unsupported_segments(proxddp, problem, problem.knots() + 1));
  EXPECT_THROW(solve(problem, "box_fddp", {.segments = 2}, guess), std::invalid_argument);
  EXPECT_THROW(solve(problem, "proxddp", {.segments = problem.knots() + 1}, guess),
               std::invalid_argument);
  EXPECT_EQ(solve(problem, "proxddp", {.segments = problem.knots()}, guess).status,
            SolveStatus::converged);
}

}  // namespace
}  // namespace conddp
