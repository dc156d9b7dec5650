// The closed loops of problems/mpc: each finishes and reaches its goal.
#include <algorithm>
#include <cmath>

#include "problem_file/assemble/build_mpc.hpp"
#include "problem_text.hpp"
#include "support/robots.hpp"

namespace conddp {
namespace {

/// Closed loop of an example problem.
struct ExampleLoop {
  explicit ExampleLoop(const std::string& name, const std::vector<std::string>& more = {}) {
    Diagnostics out;
    const auto file = kProblems / "mpc" / (name + ".yaml");
    task = build_loop(read_problem(file, more, out), {}, out);
    said = format_diagnostics(out, false);
    if (!task) return;
    built = &task->built;
    mpc = &task->mpc;
    Mpc controller(built->problem, built->guess, mpc->controller);
    result = run_closed_loop(controller, mpc->loop);
  }
  int failed() const {
    return static_cast<int>(
        std::count_if(result.ticks.begin(), result.ticks.end(),
                      [](const TickRecord& tick) { return tick.outcome != TickOutcome::planned; }));
  }

  std::unique_ptr<LoopTask> task;
  const BuiltProblem* built = nullptr;
  const BuiltMpc* mpc = nullptr;
  ClosedLoopResult result;
  std::string said;
};

TEST(MpcExample, CarFollowsItsPathAmongDiscs) {
  const ExampleLoop car("car_path");
  ASSERT_TRUE(car.mpc) << car.said;
  EXPECT_EQ(car.result.end, LoopEnd::finished);
  for (const PlantStep& step : car.result.steps)
    for (const auto& [x, y] : {std::pair(8.0, 2.5), {17.0, 2.4}, {30.0, 1.4}})
      EXPECT_GT(std::hypot(step.x[0] - x, step.x[1] - y), 1.2 - 1e-3) << step.time;
  EXPECT_NEAR(car.result.last_state[0], 36, 0.3);
  EXPECT_NEAR(car.result.last_state[1], 3 * std::sin(0.2 * 18), 0.3);
}

TEST(MpcExample, CartpoleSwingsUpInShortWindows) {
  const ExampleLoop cartpole("cartpole_balance");
  ASSERT_TRUE(cartpole.mpc) << cartpole.said;
  EXPECT_EQ(cartpole.result.end, LoopEnd::finished);
  EXPECT_EQ(cartpole.failed(), 0);
  EXPECT_NEAR(cartpole.result.last_state[0], 0, 0.05);
  EXPECT_NEAR(cartpole.result.last_state[1], M_PI, 0.05);
  const ExampleLoop without("cartpole_balance", {"mpc.terminal=none"});
  EXPECT_GT(without.result.cost, 2 * cartpole.result.cost);
}

// 5 m are too far for a window of 0.9 s. The first plan misses them by less than the guess, and the
// following plans are feasible.
TEST(MpcExample, CartpoleReachesAGoalBeyondFirstWindows) {
  const ExampleLoop cartpole(
      "cartpole_balance",
      {"solver.name=altro", "mpc.iterations=tolerances", "mpc.terminal=keep", "mpc.duration=5",
       "terminal.constraints.far={residual: state, columns: x, lower: 5, upper: 5}",
       "mpc.disturbances=[]", "mpc.fallback.after=1000"});
  ASSERT_TRUE(cartpole.mpc) << cartpole.said;
  EXPECT_EQ(cartpole.result.ticks.front().outcome, TickOutcome::improved);
  EXPECT_LT(cartpole.failed(), 20);
  EXPECT_EQ(cartpole.result.ticks.back().outcome, TickOutcome::planned);
  EXPECT_NEAR(cartpole.result.last_state[0], 5, 0.1);
  EXPECT_NEAR(cartpole.result.last_state[1], M_PI, 0.05);
}

TEST(MpcExample, QuadrupedClimbsStairs) {
  const ExampleLoop climb("quadruped_climb");
  ASSERT_TRUE(climb.mpc) << climb.said;
  EXPECT_EQ(climb.result.end, LoopEnd::finished);
  EXPECT_EQ(climb.failed(), 0);
  // Feet stand 0.3 and 0.45 m above the ground.
  EXPECT_NEAR(climb.result.last_state[2], 0.57 + 0.375, 0.03);
}

TEST(MpcExample, HopperHopsOverAnUnknownStep) {
  const ExampleLoop hopper("hopper_hops");
  ASSERT_TRUE(hopper.mpc) << hopper.said;
  EXPECT_EQ(hopper.result.end, LoopEnd::finished);
  EXPECT_EQ(hopper.failed(), 0);
  EXPECT_NEAR(hopper.result.last_state[0], 1.8, 0.2);
  EXPECT_NEAR(hopper.result.last_state[2], 0, 0.2);  // pitch
  int hops = 0;
  double before = 0;
  for (const PlantStep& step : hopper.result.steps) {
    const double rate = step.x[6];  // of the base height
    hops += before > 1e-3 && rate <= 1e-3;
    before = rate;
  }
  EXPECT_GE(hops, 10);
}

TEST(MpcExample, QuadrotorArrivesThroughGusts) {
  const ExampleLoop quadrotor("quadrotor_gusts");
  ASSERT_TRUE(quadrotor.mpc) << quadrotor.said;
  EXPECT_EQ(quadrotor.result.end, LoopEnd::finished);
  EXPECT_EQ(quadrotor.failed(), 0);
  const std::vector<double>& x = quadrotor.result.last_state;
  EXPECT_LT(std::hypot(x[0], x[1] - 10, x[2] - 1), 0.2);
}

TEST(MpcExample, ArmTracksItsGoalWithUnknownLoad) {
  const ExampleLoop arm("arm_goal");
  ASSERT_TRUE(arm.mpc) << arm.said;
  EXPECT_EQ(arm.result.end, LoopEnd::finished);
  EXPECT_EQ(arm.failed(), 0);
  const MultibodySystem& robot = *arm.built->plant.multibody();
  const Vector3<double> tool =
      placement_in_state(robot, arm.result.last_state, *robot.robot().find_frame("tool")).p;
  EXPECT_NEAR(tool.x, 0.5, 0.05);
  EXPECT_NEAR(tool.y, 0, 0.05);
  EXPECT_NEAR(tool.z, 0.4, 0.05);
}

TEST(MpcExample, HumanoidStepsInPlace) {
  const ExampleLoop biped("biped_stepping");
  ASSERT_TRUE(biped.mpc) << biped.said;
  EXPECT_EQ(biped.result.end, LoopEnd::finished);
  EXPECT_EQ(biped.failed(), 0);
  EXPECT_NEAR(biped.result.last_state[0], 0, 0.1);
  EXPECT_NEAR(biped.result.last_state[2], 0.7832, 0.05);
}

TEST(MpcExample, QuadrupedFollowsItsCommands) {
  const ExampleLoop quadruped("quadruped_commands");
  ASSERT_TRUE(quadruped.mpc) << quadruped.said;
  EXPECT_EQ(quadruped.result.end, LoopEnd::finished);
  const std::vector<double>& x = quadruped.result.last_state;
  EXPECT_GT(x[0], 0.8);
  EXPECT_GT(x[1], 0.2);
  EXPECT_NEAR(x[2], 0.6, 0.05);
  EXPECT_GT(2 * std::atan2(x[5], x[6]), 0.3);  // yaw
}

// Cones jump with the contacts and pushes; one iteration brings nearly all plans back into them.
TEST(MpcExample, QuadrupedPlansForcesInHardCones) {
  const ExampleLoop quadruped("quadruped_cones");
  ASSERT_TRUE(quadruped.mpc) << quadruped.said;
  EXPECT_EQ(quadruped.result.end, LoopEnd::finished);
  EXPECT_EQ(quadruped.failed(), 0);
  const auto& ticks = quadruped.result.ticks;
  const auto inside = std::ranges::count_if(
      ticks, [](const TickRecord& tick) { return tick.violation < 10; });  // N
  EXPECT_GT(inside, 0.9 * ticks.size());
  EXPECT_GT(quadruped.result.last_state[0], 0.8);
  EXPECT_GT(quadruped.result.last_state[1], 0.2);
}

// The ground is 1 cm higher than the controller assumes.
TEST(MpcExample, FootedHopperWithstandsPushesOnUnknownGround) {
  const ExampleLoop hopper("hopper_pushes");
  ASSERT_TRUE(hopper.mpc) << hopper.said;
  EXPECT_EQ(hopper.result.end, LoopEnd::finished);
  EXPECT_EQ(hopper.failed(), 0);
  EXPECT_NEAR(hopper.result.last_state[0], 0, 0.1);
  EXPECT_NEAR(hopper.result.last_state[1], 1.5, 0.1);
}

TEST(MpcExample, PlanarQuadrupedWithstandsPushesWithoutContactSchedule) {
  const ExampleLoop quadruped("quadruped_pushes");
  ASSERT_TRUE(quadruped.mpc) << quadruped.said;
  EXPECT_EQ(quadruped.result.end, LoopEnd::finished);
  EXPECT_EQ(quadruped.failed(), 0);
  EXPECT_NEAR(quadruped.result.last_state[0], 0, 0.1);
  EXPECT_NEAR(quadruped.result.last_state[1], 0.306, 0.02);
  EXPECT_EQ(quadruped.result.violation, 0);  // the plan's contacts are not the plant's
  int closed = 0;
  for (const PlantStep& step : quadruped.result.steps) {
    ASSERT_EQ(step.contact_forces.size(), 12u);
    closed += std::isfinite(step.contact_forces[0]);
  }
  EXPECT_GT(closed, 0);
}

TEST(MpcExample, QuadrupedCrossesAStepAtAnyPlace) {
  const std::pair<double, double> steps[] = {{0.02, 0.9}, {0.03, 0.75}};
  for (const auto& [height, place] : steps) {
    SCOPED_TRACE(fmt::format("{} m at {} m", height, place));
    const ExampleLoop quadruped(
        "quadruped_commands",
        {fmt::format("mpc.plant.ground=[ground, {{box: {{size: [0.4, 3, {}], placement: "
                     "{{position: [{}, 0, 0]}}}}}}]",
                     2 * height, place)});
    ASSERT_TRUE(quadruped.mpc) << quadruped.said;
    EXPECT_EQ(quadruped.result.end, LoopEnd::finished);
    EXPECT_EQ(quadruped.failed(), 0);
  }
}

// Windows of 0.3 s suffice only with the moving regulator at their end. The base ends at the end of
// the commanded path.
TEST(MpcExample, QuadrupedFollowsCommandsInShortRegulatedWindows) {
  const ExampleLoop quadruped(
      "quadruped_commands",
      {"mpc.horizon=0.3", "mpc.terminal={lqr: standing}",
       "mpc.commands=[{at: 0, velocity: [0.3, 0, 0]}, {at: 2, velocity: [0.3, 0, 0], turn: 0.3}]"});
  ASSERT_TRUE(quadruped.mpc) << quadruped.said;
  EXPECT_EQ(quadruped.result.end, LoopEnd::finished);
  const StatePath& way = *quadruped.mpc->loop.commands.back().terminal_path;
  const StateManifold& manifold = quadruped.built->problem->manifold();
  std::vector<double> told(manifold.nx()), tangent(manifold.ndx());
  const double end = quadruped.result.end_time + quadruped.result.ticks.back().shift;
  way.state_at(manifold, end, tangent.data(), told.data());
  const std::vector<double>& x = quadruped.result.last_state;
  EXPECT_LT(std::hypot(x[0] - told[0], x[1] - told[1]), 0.1);
  EXPECT_NEAR(std::atan2(x[5], x[6]), std::atan2(told[5], told[6]), 0.05);
  EXPECT_GT(told[5], 0.3);
}

/// The quadruped's loop with another robot, in windows of 0.6 s and with higher swings. `feet`: LF,
/// RF, LH, RH; `push`: force in N over 0.1 s, equivalent to 0.2 m/s of its mass.
std::vector<std::string> loop_of_another(const std::filesystem::path& urdf, double height,
                                         const std::string& joints, const char* const (&feet)[4],
                                         const std::string& trunk, double push) {
  std::vector<std::string> settings = {
      "robot.urdf=" + urdf.string(),
      fmt::format(
          "robot.configurations={{standing: {{base: {{position: [0, 0, {}]}}, joints: {{{}}}}}}}",
          height, joints),
      "gait.step.height=0.1",
      "mpc.horizon=0.6",
      fmt::format(
          "mpc.disturbances=[{{at: 1.5, frame: {0}, force: [0, {1}, 0], duration: 0.1}}, {{at: "
          "3.5, frame: {0}, force: [-{1}, 0, 0], duration: 0.1}}, {{noise: state, sigma: 1.0e-4}}]",
          trunk, push),
      fmt::format(
          "mpc.stop_when={{fallen: {{residual: frame_position, frame: {}, lower: {{z: {}}}}}}}",
          trunk, 0.7 * height)};
  const char* const names[] = {"LF", "RF", "LH", "RH"};
  for (int i = 0; i < 4; ++i)
    settings.push_back(fmt::format("contacts.{}.frame={}", names[i], feet[i]));
  return settings;
}

// HyQ and ANYmal trot as commanded, withstand a push, and climb an unknown step of 2 cm.
TEST(MpcExample, ForeignQuadrupedsFollowTheirCommands) {
  const auto hyq = foreign_robot_folder() / "hyq.urdf",
             anymal = foreign_robot_folder() / "anymal_b.urdf";
  if (!std::filesystem::exists(hyq) || !std::filesystem::exists(anymal))
    GTEST_SKIP() << kNoForeignRobots;
  const std::vector<std::string> loops[] = {
      loop_of_another(hyq, 0.5775,
                      "lf_haa_joint: -0.2, lf_hfe_joint: 0.75, lf_kfe_joint: -1.5, "
                      "rf_haa_joint: -0.2, rf_hfe_joint: 0.75, rf_kfe_joint: -1.5, "
                      "lh_haa_joint: -0.2, lh_hfe_joint: -0.75, lh_kfe_joint: 1.5, "
                      "rh_haa_joint: -0.2, rh_hfe_joint: -0.75, rh_kfe_joint: 1.5",
                      {"lf_foot", "rf_foot", "lh_foot", "rh_foot"}, "trunk", 174),
      loop_of_another(
          anymal, 0.4792,
          "LF_HAA: -0.1, LF_HFE: 0.7, LF_KFE: -1, RF_HAA: 0.1, RF_HFE: 0.7, RF_KFE: -1, "
          "LH_HAA: -0.1, LH_HFE: -0.7, LH_KFE: 1, RH_HAA: 0.1, RH_HFE: -0.7, RH_KFE: 1",
          {"LF_FOOT", "RF_FOOT", "LH_FOOT", "RH_FOOT"}, "base", 61)};
  for (const auto& settings : loops) {
    SCOPED_TRACE(settings[0]);
    const ExampleLoop loop("quadruped_commands", settings);
    ASSERT_TRUE(loop.mpc) << loop.said;
    EXPECT_EQ(loop.result.end, LoopEnd::finished);
    EXPECT_EQ(loop.failed(), 0);
    const std::vector<double>& x = loop.result.last_state;
    EXPECT_GT(x[0], 0.8);
    EXPECT_GT(x[1], 0.2);
    EXPECT_GT(2 * std::atan2(x[5], x[6]), 0.3);  // yaw
  }
}

}  // namespace
}  // namespace conddp
