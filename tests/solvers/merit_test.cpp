#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include <gtest/gtest.h>

#include "solvers/common/tuning.hpp"
#include "solvers/ddp/ddp_solver.hpp"
#include "solvers/globalization/open_gap_search.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// A linearized iterate with a sweep and its linear rollout.
struct SweptIterate {
  SweptIterate(const ShootingProblem& problem, Trajectory guess, bool box)
      : bounds(problem),
        evaluator(problem),
        linearization(problem),
        gaps(problem),
        trajectory(std::move(guess)),
        adjoint(problem, bounds),
        sweep(problem, bounds),
        stages(box ? box_stage(problem) : unconstrained_stage(problem)),
        feedback(problem),
        rollout(problem, bounds) {
    evaluator.differentiate(trajectory, linearization);
    gaps.set(linearization, true);
    EXPECT_EQ(sweep.run(linearization, trajectory, gaps, {}, *stages, feedback), -1);
    adjoint.compute(linearization, trajectory, gaps, feedback);
    rollout.run(linearization, trajectory, gaps, feedback, box);
  }
  /// J along the gap-contracting rollout.
  double cost(double step, LaneRollout& lanes, bool clamp = false) {
    double steps[kLaneWidth];
    for (double& s : steps) s = step;
    evaluator.roll_out(trajectory, linearization.gap, feedback, steps,
                       {.contract_gaps = true, .clamp_controls = clamp}, lanes);
    return lanes.cost[0];
  }
  ControlBounds bounds;
  Evaluator evaluator;
  Linearization linearization;
  Gaps gaps;
  Trajectory trajectory;
  Adjoint adjoint;
  BackwardSweep sweep;
  std::unique_ptr<StageSolver> stages;
  Feedback feedback;
  LinearRollout rollout;
};

/// A quadrotor guess simulated from constant controls: no gaps.
Trajectory simulated_guess(const ShootingProblem& problem) {
  Trajectory guess = testing::constant_controls(problem, 1.3);
  EXPECT_EQ(Evaluator(problem).simulate(guess), -1);
  return guess;
}

/// Rotates and moves a quadrotor's states by up to `size`, except the first.
Trajectory with_gaps(Trajectory guess, const ShootingProblem& problem, double size) {
  for (int k = 1; k <= problem.knots(); ++k) {
    Eigen::VectorXd delta(12);
    for (int i = 0; i < 12; ++i) delta[i] = size * std::sin(k * (i + 1.0));
    const Eigen::VectorXd from = guess.x(k);
    problem.manifold().integrate(from.data(), delta.data(), guess.x(k).data());
  }
  return guess;
}

/// Inconsistent quadrotor states, including rotations.
Trajectory open_gap_guess(const ShootingProblem& problem, double size = 0.2) {
  return with_gaps(testing::constant_controls(problem, 1.3), problem, size);
}

// Pitfall 9: on SE(3) the slope holds only if gaps transport tangent vectors.
TEST(Merit, SlopeIsCostDerivativeAlongManifoldRollout) {
  const ShootingProblem problem = testing::quadrotor_move();
  SweptIterate at(problem, open_gap_guess(problem), false);
  LaneRollout lanes(problem);
  const double h = 1e-6;
  const double numeric = (at.cost(h, lanes) - at.cost(-h, lanes)) / (2 * h);
  EXPECT_NEAR(at.rollout.slope(), numeric, 1e-6 * std::abs(numeric));
}

TEST(BackwardSweep, PartialSweepMatchesTheWholeSweep) {
  const ShootingProblem problem = testing::quadrotor_move();
  SweptIterate at(problem, open_gap_guess(problem), false);
  constexpr int kChanged = 7;
  at.linearization.knots[kChanged].gradient *= 2;
  const auto sweep = [&](std::optional<int> from) {
    EXPECT_EQ(at.sweep.run(at.linearization, at.trajectory, at.gaps, {}, *at.stages, at.feedback,
                           true, from),
              -1);
    return at.feedback;
  };
  const Feedback before = at.feedback, part = sweep(kChanged), whole = sweep({});
  EXPECT_NE(part.k[0], before.k[0]);
  for (int k = 0; k < problem.knots(); ++k) {
    EXPECT_EQ(part.k[k], whole.k[k]) << k;
    EXPECT_EQ(part.K[k], whole.K[k]) << k;
  }
}

TEST(FullStep, LastTrialLeavesNextIterateDerivatives) {
  using Trial = FullStep::Trial;
  const ShootingProblem problem = testing::quadrotor_move();
  SweptIterate at(problem, simulated_guess(problem), false);
  FullStep evaluated(problem, at.bounds), differentiated(problem, at.bounds);
  for (Eigen::VectorXd& k : at.feedback.k) k *= 0.1;
  at.rollout.run(at.linearization, at.trajectory, at.gaps, at.feedback, false);
  Trajectory plain = at.trajectory, ahead = at.trajectory;
  Linearization linearization = at.linearization, expected(problem);
  const auto compare = [&] {
    for (int k = 0; k <= problem.knots(); ++k) EXPECT_EQ(plain.x(k), ahead.x(k)) << k;
    EXPECT_LT((evaluated.gap() - differentiated.gap()).norm(), 1e-14);
    EXPECT_NEAR(evaluated.cost(), differentiated.cost(), 1e-14 * evaluated.cost());
  };
  evaluated.take(at.evaluator, at.rollout, Trial::evaluate, at.linearization, plain);
  differentiated.take(at.evaluator, at.rollout, Trial::evaluate, linearization, ahead);
  compare();
  evaluated.correct(at.evaluator, at.feedback, Trial::evaluate, at.linearization, plain);
  differentiated.correct(at.evaluator, at.feedback, Trial::differentiate, linearization, ahead);
  compare();
  at.evaluator.differentiate(ahead, expected);
  for (int k = 0; k <= problem.knots(); ++k) {
    EXPECT_EQ(linearization.knots[k].F, expected.knots[k].F) << k;
    EXPECT_EQ(linearization.knots[k].gradient, expected.knots[k].gradient) << k;
    EXPECT_EQ(linearization.knots[k].hessian(), expected.knots[k].hessian()) << k;
  }
  // From there, current derivatives close gaps faster than earlier ones.
  const double before = differentiated.gap().norm();
  evaluated.correct(at.evaluator, at.feedback, Trial::evaluate, at.linearization, plain);
  differentiated.correct(at.evaluator, at.feedback, Trial::evaluate, linearization, ahead);
  EXPECT_LT(differentiated.gap().norm(), 0.1 * evaluated.gap().norm());
  EXPECT_LT(differentiated.gap().norm(), 1e-3 * before);
}

// The merit ratio says little about a step that closed gaps, since the gap weight dominates.
TEST(FullStep, FollowsFullStepsThatCloseGapsAsPredicted) {
  const ShootingProblem problem = testing::quadrotor_move();
  const Trajectory optimum =
      solve(problem, "ddp", {}, testing::constant_controls(problem, 1.22625)).trajectory;
  SolverOptions options;
  options.max_iterations = 2;
  const SolveResult result = solve(problem, "fddp", options, with_gaps(optimum, problem, 0.003));
  ASSERT_EQ(result.log.size(), 3u);
  EXPECT_EQ(result.log[1].step, 1);
  EXPECT_LT(result.log[1].gap, 1e-12);
  EXPECT_EQ(result.log[2].step, 1);
  EXPECT_GT(result.log[2].gap, 1e-12) << "of second order, where a rollout closes gaps";
}

TEST(FullStep, EveryCorrectionReducesGapsByOneOrder) {
  using Trial = FullStep::Trial;
  const ShootingProblem problem = testing::quadrotor_move();
  SweptIterate at(problem, simulated_guess(problem), false);
  FullStep moved(problem, at.bounds);
  constexpr int kCorrections = 2;
  const auto gaps_of_step = [&](double size) {
    Feedback scaled = at.feedback;
    for (Eigen::VectorXd& k : scaled.k) k *= size;
    at.rollout.run(at.linearization, at.trajectory, at.gaps, scaled, false);
    Trajectory trajectory = at.trajectory;
    moved.take(at.evaluator, at.rollout, Trial::evaluate, at.linearization, trajectory);
    std::vector<double> gaps{moved.gap().norm()};
    for (int i = 0; i < kCorrections; ++i) {
      moved.correct(at.evaluator, scaled, Trial::evaluate, at.linearization, trajectory);
      gaps.push_back(moved.gap().norm());
    }
    EXPECT_DOUBLE_EQ(moved.cost(), [&] {
      Evaluation evaluation(problem);
      at.evaluator.evaluate(trajectory, evaluation);
      return evaluation.cost.sum();
    }());
    return gaps;
  };
  const std::vector<double> whole = gaps_of_step(0.1), half = gaps_of_step(0.05);
  for (int i = 0; i <= kCorrections; ++i)
    EXPECT_NEAR(std::log2(whole[i] / half[i]), 2 + i, 0.3) << i;
}

TEST(Merit, AdjointGivesTheSameSlopeForAnyPolicy) {
  const ShootingProblem problem = testing::quadrotor_move();
  SweptIterate at(problem, open_gap_guess(problem), false);
  LaneRollout lanes(problem);
  const double h = 1e-7;
  at.cost(h, lanes);
  Trajectory trial = at.trajectory;
  lanes.extract(0, trial);
  Feedback half = at.feedback;
  for (Eigen::MatrixXd& K : half.K) K *= 0.5;
  for (const Feedback& policy : {Feedback(problem), half, at.feedback}) {
    at.adjoint.compute(at.linearization, at.trajectory, at.gaps, policy);
    double slope = h * at.adjoint.gap_slope();
    Eigen::VectorXd dx(problem.ndx());
    for (int k = 0; k < problem.knots(); ++k) {
      problem.manifold().difference(at.trajectory.x(k).data(), trial.x(k).data(), dx.data());
      const Eigen::VectorXd excess = trial.u(k) - at.trajectory.u(k) - policy.K[k] * dx;
      slope += at.adjoint.gradient().segment(at.bounds.offset(k), problem.nu(k)).dot(excess);
    }
    EXPECT_NEAR(slope / h, at.rollout.slope(), 1e-4 * std::abs(at.rollout.slope()));
  }
}

TEST(Merit, GapsContractByOneMinusTheStepExactly) {
  const ShootingProblem problem = testing::quadrotor_move();
  SweptIterate at(problem, open_gap_guess(problem), false);
  LaneRollout lanes(problem);
  Trajectory next = at.trajectory;
  Evaluation evaluation(problem);
  for (double step : {1.0, 0.5, 0.125}) {
    at.cost(step, lanes);
    ASSERT_EQ(lanes.first_bad_knot[0], -1);
    lanes.extract(0, next);
    at.evaluator.evaluate(next, evaluation);
    const Eigen::MatrixXd expected = (1 - step) * at.linearization.gap;
    EXPECT_LE((evaluation.gap - expected).lpNorm<Eigen::Infinity>(), 1e-12) << step;
  }
}

TEST(Merit, TrialsFollowArmijoAndFirstAllowsRounding) {
  MeritModel merit;
  merit.rounding = 1e-10;
  constexpr double kHidden = 1e-10;
  EXPECT_TRUE(merit.passes(1, tuning::kArmijo, false));
  EXPECT_FALSE(merit.passes(1, 0.99 * tuning::kArmijo, true));
  EXPECT_FALSE(merit.passes(-1, 1, true));
  EXPECT_TRUE(merit.passes(kHidden, -kHidden, true));
  EXPECT_FALSE(merit.passes(kHidden, -kHidden, false));
  EXPECT_FALSE(merit.passes(kHidden, -1, true));
}

TEST(LineSearch, LanesHalveTheStepSuccessively) {
  double next = 0.5;
  const auto steps = lane_steps(next);
  for (int lane = 0; lane < kLaneWidth; ++lane) EXPECT_EQ(steps[lane], std::ldexp(0.5, -lane));
  EXPECT_EQ(next, std::ldexp(0.5, -kLaneWidth));
}

TEST(LineSearch, SingleTrialMatchesLanes) {
  const ShootingProblem problem = testing::quadrotor_move();
  Trajectory guess = testing::constant_controls(problem, 1.3);
  Evaluator(problem).simulate(guess);
  SweptIterate at(problem, guess, false);
  LineSearch search(problem);
  constexpr double kShort = 0.1;  // where the model is accurate
  for (Eigen::VectorXd& k : at.feedback.k) k *= kShort;
  const MeritModel merit{.cost = at.linearization.total_cost(),
                         .slope = kShort * at.rollout.slope()};
  const auto run = [&](const MeritModel& by, Trajectory& trajectory) {
    return search.run(at.evaluator, by, at.adjoint, at.linearization.gap, at.feedback, {}, 1,
                      trajectory);
  };
  Trajectory alone = guess, in_lanes = guess, none = guess;
  const LineSearchResult first = run(merit, alone);
  EXPECT_TRUE(first.accepted);
  EXPECT_EQ(first.trials, 1);
  // An unattainable slope: after two failures, the search uses all lanes at once.
  MeritModel hopeless = merit;
  hopeless.slope *= 1e6;
  for (int i = 0; i < 2; ++i) EXPECT_FALSE(run(hopeless, none).accepted);
  const LineSearchResult second = run(merit, in_lanes);
  EXPECT_EQ(second.step, first.step);
  EXPECT_NEAR(second.actual_decrease, first.actual_decrease, 1e-12 * merit.cost);
  EXPECT_LT((alone.x(problem.knots()) - in_lanes.x(problem.knots())).norm(), 1e-10);
}

// Pitfall 8: too small a weight can make closing gaps look like ascent.
TEST(Merit, OpenGapWeightMakesTheDirectionDescend) {
  const ShootingProblem problem = testing::quadrotor_move();
  const ControlBounds bounds(problem);
  int costly = 0;
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u, 7u, 8u}) {
    SweptIterate at(problem, testing::random_guess(problem, seed, 0.1), false);
    MeritModel merit{.gap_norm = at.linearization.gap.lpNorm<1>(), .slope = at.rollout.slope()};
    const double curvature = at.rollout.curvature(at.linearization);
    OpenGapSearch search(problem, bounds, false);
    merit.penalty = search.weigh(merit, curvature);
    costly += merit.slope > 0;
    EXPECT_LE(merit.merit_slope(), -0.5 * curvature + 1e-9 * curvature) << seed;
  }
  EXPECT_GT(costly, 0) << "closing the gaps costs something";
}

TEST(Merit, NoStepTradesWideGapsForLowerCost) {
  const testing::PublishedCase cartpole = std::move(testing::published_cases()[2]);
  constexpr double kClosed = 1e-9;
  double before = std::numeric_limits<double>::infinity();
  for (int iterations = 0; iterations <= 6; ++iterations) {
    const SolveResult result =
        solve(cartpole.problem, "altro", {.max_iterations = iterations},
              testing::constant_controls(cartpole.problem, cartpole.control));
    Evaluation evaluation(cartpole.problem);
    Evaluator(cartpole.problem).evaluate(result.trajectory, evaluation);
    const double gaps = evaluation.gap.lpNorm<1>();
    EXPECT_LE(gaps, std::max(kClosed, 1.5 * before)) << iterations;
    before = gaps;
  }
}

TEST(Merit, EveryIterationLowersMeritAndLastClosesGaps) {
  const struct {
    const char* solver;
    ShootingProblem problem;
  } cases[] = {{"fddp", testing::quadrotor_move()}, {"box_fddp", testing::quadrotor_move(0.5, 2)}};
  for (const auto& [solver, problem] : cases) {
    // With exact Hessians, all steps are rollouts.
    const SolveResult result =
        solve(problem, solver, {.hessian = HessianChoice::exact}, open_gap_guess(problem, 0.02));
    EXPECT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_GT(result.log[0].gap, 1e-3);
    for (std::size_t i = 1; i < result.log.size(); ++i)
      EXPECT_GE(result.log[i].actual_decrease, -1e-12 * result.cost) << solver << ' ' << i;
    EXPECT_LE(result.log.back().gap, 1e-9) << solver;
  }
}

TEST(Merit, ControlsStayWithinBoundsWithOpenGaps) {
  const ShootingProblem problem = testing::quadrotor_move(0.9, 1.5);
  Trajectory guess = open_gap_guess(problem, 0.02);
  for (int k = 0; k < problem.knots(); ++k) guess.u(k).setConstant(5);
  SolverOptions options;
  double worst = 0;
  options.on_iteration = [&](const IterationRecord& row) {
    worst = std::max(worst, row.constraint);
  };
  const SolveResult result = solve(problem, "box_fddp", options, guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_EQ(worst, 0);
  EXPECT_NE(result.start.find("200 control entries moved"), std::string::npos) << result.start;
}

TEST(Start, OpenGapSolversReportInitialStateCorrections) {
  const ShootingProblem problem = testing::unicycle_parking();
  Trajectory guess = testing::constant_controls(problem, 0.1);
  guess.x(0)[1] = 0.5;
  const SolveResult result = solve(problem, "fddp", {}, guess);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(result.trajectory.x(0)[1], 0);
  EXPECT_NE(result.start.find("x_0 corrected by 0.5"), std::string::npos) << result.start;
}

TEST(Start, ClosedGapSolversIgnoreGuessedStates) {
  const ShootingProblem problem = testing::unicycle_parking();
  Trajectory guess = testing::constant_controls(problem, 0.1);
  const SolveResult a = solve(problem, "ilqr", {}, guess);
  for (int k = 0; k <= problem.knots(); ++k) guess.x(k).setConstant(1e3);
  const SolveResult b = solve(problem, "ilqr", {}, guess);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.log.size(), b.log.size());
}

TEST(Start, NormalizesOrRejectsGuessedQuaternions) {
  const ShootingProblem problem = testing::quadrotor_move();
  Trajectory guess = open_gap_guess(problem);
  guess.x(7).segment(3, 4) *= 1 + 1e-6;
  EXPECT_EQ(solve(problem, "fddp", {}, guess).status, SolveStatus::converged);
  guess.x(7).segment(3, 4) *= 2;
  EXPECT_THROW(solve(problem, "fddp", {}, guess), std::invalid_argument);
}

}  // namespace
}  // namespace conddp
