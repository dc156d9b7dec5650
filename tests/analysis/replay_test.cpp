// A block on slides whose motion is known analytically for any step length.
#include "analysis/certificate/replay.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

#include "ocp/knot/collocation_residual.hpp"
#include "support/block_on_slides.hpp"
#include "support/expression_systems.hpp"
#include "support/steps.hpp"
#include "systems/collocation_system.hpp"

namespace conddp {
namespace {

using testing::block_phase;
using testing::block_problem;
using testing::block_system;

constexpr double kBorne = 2 * 9.81;

/// Pushed along x, supported along z, with states of one step per knot.
Trajectory pushed_along_x(const ShootingProblem& problem, const std::vector<double>& pushes) {
  Trajectory motion = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k) {
    motion.u(k) << pushes[k], 0, kBorne;
    motion.x(k + 1) = motion.x(k);
    motion.x(k + 1)[3] += 0.1 * pushes[k] / 4;
    motion.x(k + 1)[0] += 0.1 * motion.x(k + 1)[3];
  }
  return motion;
}

std::vector<Eigen::MatrixXd> position_gains(int knots, double position = 0, double velocity = 0) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3, 6);
  K(0, 0) = position;
  K(0, 3) = velocity;
  return std::vector<Eigen::MatrixXd>(knots, K);
}

// 0.1 s at 1 m/s² in n steps moves 0.01 (n + 1) / (2 n) m: 10 mm in one step, 7.5 mm in two.
TEST(Replay, FollowsFinerSteps) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 3)});
  const Trajectory motion = pushed_along_x(problem, {4, 0, -4});
  const Replay found = replay(problem, motion, position_gains(3), 2);
  EXPECT_EQ(found.impossible, "");
  EXPECT_EQ(found.substeps, 2);
  EXPECT_NEAR(found.controls.deviation, 0.0025, 1e-12);
  EXPECT_EQ(found.controls.entry, 0);
  EXPECT_TRUE(found.controls.knot == 1 || found.controls.knot == 2);  // equal up to rounding
  EXPECT_NEAR(found.controls.final_state, 0, 1e-12);  // braked as it was accelerated
  EXPECT_NEAR(found.controls.relative, 0.0025 / 0.02, 1e-12);
  EXPECT_EQ(found.controls.lost_at, -1);
  EXPECT_NEAR(found.feedback.deviation, 0.0025, 1e-12);
  EXPECT_EQ(found.feedback.saturated, 0);
  EXPECT_TRUE(found.broken.empty());
}

TEST(Replay, BeginsAtTheInitialStateOfTheProblem) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 2)});
  Trajectory motion = pushed_along_x(problem, {0, 0});
  motion.x(1)[1] = 0.002;
  motion.x(2)[4] = -0.05;
  const Replay found = replay(problem, motion, position_gains(2));
  EXPECT_NEAR(found.controls.deviation, 0.05, 1e-12);
  EXPECT_EQ(found.controls.knot, 2);
  EXPECT_EQ(found.controls.entry, 4);
  EXPECT_NEAR(found.controls.final_state, 0.05, 1e-12);
  // Motions below a hundredth are scaled by a hundredth.
  EXPECT_NEAR(found.controls.relative, 1, 1e-12);
}

TEST(Replay, SmallMotionsAreRelativeToAHundredth) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 2)});
  Trajectory motion = pushed_along_x(problem, {0, 0});
  motion.x(2)[1] = 0.002;
  EXPECT_NEAR(replay(problem, motion, position_gains(2)).controls.relative, 0.2, 1e-12);
}

/// u = u_k + k_q (q − q_k) + k_v (v − v_k) within the limit, over the substeps of a knot.
ReplayRun by_hand(const Trajectory& motion, double kq, double kv, double limit, int substeps) {
  ReplayRun run;
  double q = 0, v = 0;
  for (int k = 0; k < motion.knots(); ++k) {
    const double wish = motion.u(k)[0] + kq * (q - motion.x(k)[0]) + kv * (v - motion.x(k)[3]);
    const double u = std::max(-limit, std::min(limit, wish));
    run.saturated += u != wish;
    for (int s = 0; s < substeps; ++s) {
      v += 0.1 / substeps * u / 4;
      q += 0.1 / substeps * v;
    }
    const double off = std::max(std::abs(q - motion.x(k + 1)[0]), std::abs(v - motion.x(k + 1)[3]));
    if (off > run.deviation) run.deviation = off, run.knot = k + 1;
    run.final_state = off;
  }
  return run;
}

TEST(Replay, HoldsBoundedFeedbackOverAKnot) {
  for (const double limit : {100.0, 4.2}) {
    std::vector<Phase> phases;
    phases.push_back(block_phase(block_system(), 4, limit));
    // Unused gains support the weight along z; the bound must allow it.
    auto model = std::make_shared<KnotModel>(*phases.front().model);
    model->set_control_bounds({-limit, -limit, -100}, {limit, limit, 100});
    phases.front().model = model;
    const ShootingProblem problem = block_problem(std::move(phases));
    const Trajectory motion = pushed_along_x(problem, {4, 4, -3, 4});
    const Replay found = replay(problem, motion, position_gains(4, -150, -20), 5);
    const ReplayRun expected = by_hand(motion, -150, -20, limit, 5);
    EXPECT_NEAR(found.feedback.deviation, expected.deviation, 1e-10);
    EXPECT_EQ(found.feedback.knot, expected.knot);
    EXPECT_NEAR(found.feedback.final_state, expected.final_state, 1e-10);
    EXPECT_EQ(found.feedback.saturated, expected.saturated);
    EXPECT_EQ(expected.saturated > 0, limit < 5);
  }
}

TEST(Replay, FindsLimitsOfJointsWithinSteps) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 3)});
  // 1.6 m/s after the first step, 1.4 m/s after the second: 0.1 m/s too fast at a single knot.
  const Trajectory motion = pushed_along_x(problem, {64, -8, 0});
  const Replay found = replay(problem, motion, position_gains(3), 10);
  ASSERT_EQ(found.broken.size(), 1u);
  EXPECT_EQ(found.broken[0].quantity, "velocity of x");
  EXPECT_EQ(found.broken[0].unit, "m/s");
  EXPECT_NEAR(found.broken[0].excess, 0.1, 1e-12);
  EXPECT_EQ(found.broken[0].knot, 1);
  EXPECT_NEAR(found.broken[0].time, 0.1, 1e-12);
  EXPECT_FALSE(found.broken[0].between);
}

TEST(Replay, FindsLimitsViolatedOnlyBetweenKnots) {
  std::vector<double> start = {0.46, 0, 0, 1, 0, 0};
  const auto system = block_system();
  auto phase = block_phase(system, 2);
  std::vector<Phase> phases;
  phases.push_back(std::move(phase));
  const ShootingProblem problem(
      start, std::move(phases),
      testing::terminal_phase(
          system, {.goal = std::vector<double>(6, 0.0), .qf = std::vector<double>(6, 1.0)}));
  // Braked by 20 m/s² in steps of 10 ms, it moves 0.8, 0.6, 0.4, 0.2, 0, −0.2 … cm. It peaks at
  // 0.48 m and reaches the lower limit within the second knot.
  Trajectory motion = pushed_along_x(problem, {-80, 80});
  Replay found = replay(problem, motion, position_gains(2), 10);
  EXPECT_TRUE(found.broken.empty());
  // At 10 m/s²: 0.9, 0.8, … 0 cm, with 0.505 after nine and ten steps in the second knot.
  motion = pushed_along_x(problem, {-40, -40});
  found = replay(problem, motion, position_gains(2), 10);
  ASSERT_EQ(found.broken.size(), 1u);
  EXPECT_EQ(found.broken[0].quantity, "position of x");
  EXPECT_EQ(found.broken[0].unit, "m");
  EXPECT_NEAR(found.broken[0].excess, 0.005, 1e-12);
  EXPECT_NEAR(found.broken[0].time, 0.095, 0.006);
  // At 12.5 m/s² in steps of 20 ms: 1.5, 1, 0.5, 0, −0.5 cm, at most 0.49; from 0.475: 0.505.
  std::vector<Phase> again;
  again.push_back(block_phase(system, 2));
  start[0] = 0.475;
  const ShootingProblem nearer(
      start, std::move(again),
      testing::terminal_phase(
          system, {.goal = std::vector<double>(6, 0.0), .qf = std::vector<double>(6, 1.0)}));
  motion = pushed_along_x(nearer, {-50, -50});
  found = replay(nearer, motion, position_gains(2), 5);
  ASSERT_EQ(found.broken.size(), 1u);
  EXPECT_NEAR(found.broken[0].excess, 0.005, 1e-12);
  EXPECT_EQ(found.broken[0].knot, 0);
  EXPECT_NEAR(found.broken[0].time, 0.07, 0.011);
  EXPECT_TRUE(found.broken[0].between);
}

TEST(Replay, FindsPullingContacts) {
  const ShootingProblem problem = block_problem({block_phase(block_system({{.name = "grip"}}), 3)});
  Trajectory motion = problem.create_trajectory();
  motion.u(0) << 0, 0, kBorne - 1;
  motion.u(1) << 3, 0, kBorne + 2;
  motion.u(2) << 0, 0, 0;
  const Replay found = replay(problem, motion, position_gains(3), 4);
  ASSERT_EQ(found.broken.size(), 1u);
  EXPECT_EQ(found.broken[0].quantity, "pull of grip");
  EXPECT_EQ(found.broken[0].unit, "N");
  EXPECT_NEAR(found.broken[0].excess, 2, 1e-9);
  EXPECT_EQ(found.broken[0].knot, 1);
  EXPECT_NEAR(found.broken[0].time, 0.1, 1e-12);
}

TEST(Replay, ReportsWhereAMotionIsLost) {
  const ShootingProblem problem = block_problem({block_phase(block_system(), 3)});
  Trajectory motion = pushed_along_x(problem, {0, 0, 0});
  motion.x(2)[0] = 10;
  auto wild = position_gains(3);
  wild[2](0, 0) = 1e308;
  const Replay found = replay(problem, motion, wild, 2);
  EXPECT_EQ(found.controls.lost_at, -1);
  EXPECT_EQ(found.feedback.lost_at, 2);
  motion.u(1)[0] = std::nan("");
  EXPECT_EQ(replay(problem, motion, position_gains(3)).impossible, "the trajectory is not finite");
}

TEST(Replay, NeedsTimeBetweenKnots) {
  const auto system = linear_system(Eigen::Matrix2d::Identity(), Eigen::Matrix2d::Identity(),
                                    Eigen::Vector2d::Zero());
  const ShootingProblem problem =
      testing::tracking_problem(system, Integrator::discrete, 2, 1, {0, 0},
                                {.goal = {0, 0}, .q = {1, 1}, .r = {1, 1}, .qf = {1, 1}});
  EXPECT_NE(replay(problem, problem.create_trajectory(),
                   std::vector<Eigen::MatrixXd>(2, Eigen::MatrixXd::Zero(2, 2)))
                .impossible,
            "");
}

/// A point on a line moving at speed 1 that is thrown back at half that speed.
struct ThrownBack {
  ShootingProblem problem;
  Trajectory motion;

  ThrownBack() : problem(made()), motion(problem.create_trajectory()) {
    const double x[][2] = {{0, 1}, {0.1, 1}, {0.2, 1}, {0.2, -0.5}, {0.15, -0.5}, {0.1, -0.5}};
    for (int k = 0; k <= problem.knots(); ++k) motion.x(k) << x[k][0], x[k][1];
  }

 private:
  static ShootingProblem made() {
    const auto point = double_integrator(1);
    const auto back = linear_system(Eigen::Vector2d(1, -0.5).asDiagonal().toDenseMatrix(),
                                    Eigen::MatrixXd(2, 0), Eigen::Vector2d::Zero());
    const testing::TrackingCost cost{.goal = {0, 0}, .q = {1, 1}, .r = {1}};
    const auto move = [&] {
      return testing::tracking_phase(point, Integrator::semi_implicit_euler, 2, 0.1, cost,
                                     -testing::kFree, testing::kFree);
    };
    std::vector<Phase> phases;
    phases.push_back(move());
    phases.push_back({.name = "back",
                      .model = std::make_shared<KnotModel>(back, Integrator::discrete),
                      .dt = {0},
                      .cost_scale = {1}});
    phases.push_back(move());
    return {
        {0, 1}, std::move(phases), testing::terminal_phase(point, {.goal = {0, 0}, .qf = {1, 1}})};
  }
};

TEST(Replay, PassesJumpsOfStates) {
  const ThrownBack thrown;
  const int N = thrown.problem.knots();
  std::vector<Eigen::MatrixXd> gains;
  for (int k = 0; k < N; ++k) gains.push_back(Eigen::MatrixXd::Zero(thrown.problem.nu(k), 2));
  Replay found = replay(thrown.problem, thrown.motion, gains, 5);
  EXPECT_EQ(found.impossible, "");
  EXPECT_NEAR(found.controls.deviation, 0, 1e-12);
  EXPECT_NEAR(found.feedback.deviation, 0, 1e-12);
  Trajectory wrong = thrown.motion;
  wrong.x(3)[1] = -1;
  found = replay(thrown.problem, wrong, gains, 5);
  EXPECT_NEAR(found.controls.deviation, 0.5, 1e-12);
  EXPECT_EQ(found.controls.knot, 3);
}

/// Three knots of 0.1 s of a system under a collocation rule.
ShootingProblem in_steps_of(const std::shared_ptr<const System>& inside, CollocationRule rule,
                            std::vector<double> start) {
  const auto system = std::make_shared<CollocationSystem>(inside, rule);
  const auto* integrator =
      std::find_if(std::begin(kIntegrators), std::end(kIntegrators),
                   [&](const IntegratorInfo& info) { return info.collocation == rule; });
  auto model = std::make_shared<KnotModel>(system, integrator->integrator);
  model->add_constraint(make_constraint("collocation", collocation_residual(system, model->ndx()),
                                        ConstraintKind::bounds));
  Phase phase{.name = "all", .model = model, .dt = {0.1, 0.1, 0.1}, .cost_scale = {1, 1, 1}};
  const ConstraintTerm& term = model->constraints().front();
  for (int k = 0; k < 3; ++k) {
    std::vector<double> one(model->parameter_count(), 0.0);
    one[term.parameters] = 0.1;
    one[term.active()] = 1;
    phase.parameters.insert(phase.parameters.end(), one.begin(), one.end());
  }
  std::vector<Phase> phases;
  phases.push_back(std::move(phase));
  return {std::move(start),
          std::move(phases),
          {.name = "end",
           .model = std::make_shared<KnotModel>(system, Integrator::none),
           .dt = {0},
           .cost_scale = {1}}};
}

/// A pushed cart-pole, integrated by a collocation rule and, as reference, by very small
/// Runge-Kutta steps.
struct PushedCart {
  ShootingProblem problem;
  Trajectory motion;

  explicit PushedCart(CollocationRule rule)
      : problem(in_steps_of(cartpole({}), rule, {0.1, 2, 0.3, -1})),
        motion(problem.create_trajectory()) {
    const auto inside = cartpole({});
    const auto data = inside->create_data(double{});
    IntegratorWorkspace<double> work(*inside, Integrator::rk4);
    constexpr int kParts = 200;
    for (int k = 0; k < problem.knots(); ++k) {
      motion.u(k)[0] = 3 - 2 * k;
      motion.x(k + 1) = motion.x(k);
      for (int i = 0; i < kParts; ++i) {
        inside->evaluate(motion.x(k + 1).data(), motion.u(k).data(), *data);
        integrate(*inside, Integrator::rk4, motion.x(k + 1).data(), motion.u(k).data(),
                  0.1 / kParts, *data, work);
        std::copy(work.next.begin(), work.next.end(), motion.x(k + 1).data());
      }
    }
  }

  double deviation(int substeps) const {
    std::vector<Eigen::MatrixXd> none(problem.knots(),
                                      Eigen::MatrixXd::Zero(problem.nu(0), problem.ndx()));
    const Replay found = replay(problem, motion, none, substeps);
    EXPECT_EQ(found.impossible, "");
    EXPECT_EQ(found.controls.lost_at, -1);
    EXPECT_NEAR(found.feedback.deviation, found.controls.deviation, 1e-12);
    return found.controls.deviation;
  }
};

// The planned slopes are all zero; the replay solves for its own.
TEST(Replay, CollocationSolvesForStepSlopes) {
  const PushedCart trapezoidal(CollocationRule::trapezoidal),
      simpson(CollocationRule::hermite_simpson);
  // Orders two and four.
  EXPECT_LT(trapezoidal.deviation(20), 1e-3);
  EXPECT_NEAR(std::log2(trapezoidal.deviation(10) / trapezoidal.deviation(20)), 2, 0.1);
  EXPECT_LT(simpson.deviation(10), 1e-7);
  EXPECT_NEAR(std::log2(simpson.deviation(4) / simpson.deviation(8)), 4, 0.3);
  const PushedCart radau3(CollocationRule::radau3), radau5(CollocationRule::radau5);
  EXPECT_NEAR(std::log2(radau3.deviation(4) / radau3.deviation(8)), 3, 0.3);
  EXPECT_NEAR(std::log2(radau5.deviation(2) / radau5.deviation(4)), 5, 0.5);
}

// Slopes of 10⁹ are accurate to rounding.
TEST(Replay, FindsLargeCollocationSlopes) {
  const auto fast =
      expression_system({.kind = SystemKind::first_order,
                         .states = {{"x"}, {"y"}},
                         .controls = {{"u", "1"}},
                         .equations = {{"x", "-0.3*x + 7.7*y + u"}, {"y", "-1.1*x - 0.7*y"}}});
  for (const CollocationRule rule : {CollocationRule::trapezoidal, CollocationRule::radau5}) {
    const ShootingProblem problem = in_steps_of(fast, rule, {1.1e9, -0.7e9});
    const std::vector<Eigen::MatrixXd> none(3, Eigen::MatrixXd::Zero(problem.nu(0), problem.ndx()));
    const Replay found = replay(problem, problem.create_trajectory(), none, 3);
    EXPECT_EQ(found.impossible, "");
    EXPECT_EQ(found.controls.lost_at, -1);
    EXPECT_GT(found.controls.deviation, 1e8);
  }
}

TEST(Replay, RemembersTheUsedControls) {
  const auto system = block_system();
  auto model = std::make_shared<KnotModel>(
      step_with(system, Integrator::semi_implicit_euler, Memory::previous));
  auto end = std::make_shared<KnotModel>(step_with(system, Integrator::none, Memory::previous));
  std::vector<Phase> phases;
  phases.push_back({"all", model, {0.1, 0.1, 0.1}, {1, 1, 1}, {}});
  std::vector<double> start(9, 0.0);
  start[7] = 0.5;
  const ShootingProblem problem(start, std::move(phases), {"end", end, {0}, {1}, {}});
  Trajectory motion = pushed_along_x(problem, {4, 2, -4});
  for (int k = 0; k < 3; ++k) motion.x(k + 1).tail(3) = motion.u(k);
  // Gains on remembered controls only: the motion is as planned.
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(3, 9);
  K.rightCols(3).setConstant(50);
  const Replay found = replay(problem, motion, std::vector<Eigen::MatrixXd>(3, K), 1);
  EXPECT_NEAR(found.controls.deviation, 0, 1e-12);
  EXPECT_NEAR(found.feedback.deviation, 0, 1e-12);
}

}  // namespace
}  // namespace conddp
