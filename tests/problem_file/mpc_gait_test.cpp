// Closed-loop regulators that move with the gait of their file.
#include <algorithm>
#include <cmath>

#include "problem_file/assemble/build_mpc.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

/// A closed loop of a file of problems/, with further settings.
struct GaitLoop {
  GaitLoop(const std::string& name, const std::vector<std::string>& settings)
      : task(build_loop(read_problem(kProblems / (name + ".yaml"), settings, out), {}, out)) {
    if (!task) return;
    built = &task->built;
    mpc = &task->mpc;
  }
  ClosedLoopResult run() const {
    Mpc controller(built->problem, built->guess, mpc->controller);
    return run_closed_loop(controller, mpc->loop);
  }
  std::string said() const { return format_diagnostics(out, false); }

  Diagnostics out;
  std::unique_ptr<LoopTask> task;
  const BuiltProblem* built = nullptr;
  const BuiltMpc* mpc = nullptr;
};

/// The trot of two cycles of 0.15 m with windows that end in a regulator.
GaitLoop trot_of_regulator(const std::string& mpc, const std::vector<std::string>& more = {}) {
  std::vector<std::string> settings = {
      "mpc={horizon: 0.3, tick: 0.02, " + mpc + "}",
      "costs.posture.weights={\"base/*\": 1, \"base/z\": 10, \"base/r*\": 100, \"q/*\": 1, "
      "\"base/v*\": 0.1, \"base/w*\": 1, \"v/*\": 0.01}"};
  settings.insert(settings.end(), more.begin(), more.end());
  return {"quadruped_trot", settings};
}

std::vector<double> state_of(const StatePath& path, const StateManifold& manifold, double time) {
  std::vector<double> x(manifold.nx()), tangent(manifold.ndx());
  path.state_at(manifold, time, tangent.data(), x.data());
  return x;
}

/// At each node, the regulator about a posture is at the reference of the cost on that posture.
void expect_moves_with_posture(const StatePath& path, const ShootingProblem& problem) {
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotView& knot = problem.knot(k);
    const auto& costs = knot.model->costs();
    const auto posture = std::find_if(costs.begin(), costs.end(),
                                      [](const CostTerm& c) { return c.name == "posture"; });
    ASSERT_NE(posture, costs.end());
    const std::vector<double> x = state_of(path, problem.manifold(), problem.times()[k]);
    for (int i = 0; i < problem.nx(); ++i)
      EXPECT_NEAR(x[i], knot.parameters[posture->parameters + i], 1e-9) << k << ' ' << i;
  }
}

TEST(GaitRegulator, MovesLikeReferencesDisplacedWithTheGait) {
  const GaitLoop loop = trot_of_regulator(
      "duration: 1, terminal: {lqr: standing}, commands: [{at: 0.2, velocity: [0.3, 0.1, 0]}, {at: "
      "0.5, velocity: [0.3, 0, 0], turn: 0.5}]",
      {"gait.step.turn=0.2"});
  ASSERT_TRUE(loop.mpc) << loop.said();
  ASSERT_TRUE(loop.mpc->controller.terminal_path);
  expect_moves_with_posture(*loop.mpc->controller.terminal_path, *loop.built->problem);
  ASSERT_EQ(loop.mpc->loop.commands.size(), 2u);
  for (const LoopCommand& command : loop.mpc->loop.commands) {
    ASSERT_TRUE(command.terminal_path);
    expect_moves_with_posture(*command.terminal_path, *command.numbers);
  }
  const StatePath &gait = *loop.mpc->controller.terminal_path,
                  &led = *loop.mpc->loop.commands[1].terminal_path;
  const double end = loop.built->problem->times().back();
  EXPECT_NE(state_of(gait, loop.built->problem->manifold(), end),
            state_of(led, loop.built->problem->manifold(), end));
}

TEST(GaitRegulator, StaysAtItsExplicitlyDisplacedState) {
  const GaitLoop loop = trot_of_regulator(
      "duration: 1, terminal: {lqr: {configuration: standing, displaced: [0, 0, 0]}}");
  ASSERT_TRUE(loop.mpc) << loop.said();
  EXPECT_FALSE(loop.mpc->controller.terminal_path);
  EXPECT_EQ(loop.mpc->controller.terminal->parameters[0], 0);
}

// Displacing and rotating the loop changes only its place and heading, except for friction
// pyramids, whose sides are fixed in the world.
TEST(GaitRegulator, LoopsAreInvariantToTheirStart) {
  const std::string mpc =
      "duration: 0.8, repeat: gait, feedback: {rate: 200}, terminal: {lqr: standing}, commands: "
      "[{at: 0.1, velocity: [0.3, 0, 0]}, {at: 0.4, velocity: [0.2, 0.1, 0], turn: 0.5}]";
  const double angle = 0.7, x0 = 1, y0 = -2;
  const std::string without = "costs.cone.weight=0";
  const GaitLoop here = trot_of_regulator(mpc, {without});
  const GaitLoop there = trot_of_regulator(
      mpc,
      {without, "robot.configurations.standing.base={position: [1, -2, 0.57], rpy: [0, 0, 0.7]}"});
  ASSERT_TRUE(here.mpc && there.mpc) << here.said() << there.said();
  const std::vector<double> a = here.run().last_state, b = there.run().last_state;
  EXPECT_GT(std::hypot(a[0], a[1]), 0.05);
  EXPECT_NEAR(b[0], x0 + std::cos(angle) * a[0] - std::sin(angle) * a[1], 1e-9);
  EXPECT_NEAR(b[1], y0 + std::sin(angle) * a[0] + std::cos(angle) * a[1], 1e-9);
  EXPECT_NEAR(std::atan2(b[5], b[6]), std::atan2(a[5], a[6]) + angle / 2, 1e-9);
  for (std::size_t i = 7; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-9) << i;
}

/// Distance in m that the base moves after a fallback activates, on the last stand of the trot,
/// half a meter from the start.
double way_under_fallback(const std::string& to) {
  const GaitLoop loop = trot_of_regulator(
      "duration: 2.5, feedback: {rate: 500}, disturbances: [{late: 1, at: 1.5}], fallback: "
      "{after: 1, to: {lqr: " +
          to + "}}",
      {"gait.step.length=0.25", "costs.posture.weight=100"});
  if (!loop.mpc) {
    ADD_FAILURE() << loop.said();
    return 0;
  }
  const ClosedLoopResult result = loop.run();
  EXPECT_TRUE(result.ticks.back().fallback);
  EXPECT_NEAR(result.last_state[2], 0.57, 0.03);
  const auto from = std::ranges::find_if(
      result.steps, [](const PlantStep& step) { return step.time >= 1.5 - kSameTime; });
  EXPECT_NEAR(from->x[0], 0.5, 0.05);
  return result.last_state[0] - from->x[0];
}

TEST(GaitRegulator, FallbackHoldsItsStateAtTheCurrentPlace) {
  EXPECT_NEAR(way_under_fallback("standing"), 0, 0.02);
  EXPECT_LT(way_under_fallback("{configuration: standing, displaced: [0, 0, 0]}"), -0.04);
}

TEST(GaitRegulator, PlanarBaseDoesNotTurn) {
  const auto said = [](const std::string& commands) {
    return GaitLoop("mpc/hopper_hops", {"mpc.terminal={lqr: standing}", "mpc.duration=0.4",
                                        "mpc.disturbances=[]", "mpc.commands=" + commands})
        .said();
  };
  const std::string turns = "the regulator of a planar base does not follow a gait that turns";
  EXPECT_NE(said("[{at: 0, velocity: [0.2, 0, 0], turn: 0.1}]").find(turns), std::string::npos);
  EXPECT_EQ(said("[{at: 0, velocity: [0.2, 0, 0]}]").find(turns), std::string::npos);
}

}  // namespace
}  // namespace conddp
