// Loops, contacts between frames, frames of the file, and residuals between frames.
#include <cmath>

#include "problem_file/assemble/problem_names.hpp"
#include "problem_file/motion/contact_plan.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

/// A leg of five bars that stands, jumps and lands.
constexpr std::string_view kLeg = R"(conddp: 1
robot: {urdf: robots/five_bar_leg.urdf, actuation: {joints: [hip_a, hip_b]}}
loops:
  ankle: {frame: foot, to: foot_b, type: planar, tangent: [1, 0, 0]}
contacts:
  ground: {frame: foot, type: planar}
initial_state: {joints: {slide: 0.2114654, hip_a: 1.2, knee_a: -1.901688, hip_b: -1.2, knee_b: 1.901688}}
phases:
  - {name: push, knots: 4, dt: 0.01, contacts: ground}
  - {name: flight, knots: 4, dt: 0.01}
  - {name: touch_down, impulse: ground}
  - {name: land, knots: 4, dt: 0.01, contacts: all}
costs:
  effort: {residual: control}
)";

/// "line:column: message (hint)" of the errors in a wrong text, one a line.
std::string errors(const std::string& text) {
  const Loaded loaded(text);
  EXPECT_FALSE(loaded.built);
  std::string lines;
  for (const Diagnostic& d : loaded.diagnostics.list())
    if (d.severity == Severity::kError)
      lines += fmt::format("{}:{}: {} ({})\n", d.line, d.column, d.message, d.hint);
  return lines;
}

std::vector<std::string> held_in(const BuiltProblem& built, int knot) {
  std::vector<std::string> names;
  const auto* robot = built.problem->knot(knot).model->system().as_multibody();
  for (const Contact& contact : robot->contacts().contacts()) names.push_back(contact.name);
  return names;
}

TEST(LoopFile, EveryPhaseAndImpulseHoldsLoops) {
  const Loaded leg{std::string(kLeg)};
  ASSERT_TRUE(leg.built) << leg.all();
  using Names = std::vector<std::string>;
  EXPECT_EQ(held_in(*leg.built, 0), (Names{"ground", "ankle"}));
  EXPECT_EQ(held_in(*leg.built, 5), Names{"ankle"});
  EXPECT_EQ(held_in(*leg.built, 8), (Names{"ground", "ankle"}));
  EXPECT_EQ(held_in(*leg.built, 9), (Names{"ground", "ankle"}));
  const auto* robot = leg.built->problem->knot(5).model->system().as_multibody();
  const Contact& ankle = robot->contacts().contacts().front();
  EXPECT_EQ(ankle.kp, 100);
  EXPECT_EQ(ankle.kd, 20);
  EXPECT_EQ(squared_norm(ankle.normal - Vector3<double>{0, 0, 1}), 0);
  const Loaded plain(replaced(kLeg, ", type: planar, tangent: [1, 0, 0]", ""));
  ASSERT_TRUE(plain.built) << plain.all();
  const auto* point = plain.built->problem->knot(5).model->system().as_multibody();
  EXPECT_EQ(point->contacts().contacts().front().kind, ContactKind::point);
  EXPECT_EQ(point->contacts().contacts().front().axes, FrameAxes::world_aligned);
}

TEST(LoopFile, OpenLoopsAreErrorsThatCloseThem) {
  const std::string open = replaced(kLeg, "hip_a: 1.2", "hip_a: 1.1");
  const std::string text = errors(open), says = "it closes with {";
  EXPECT_EQ(text.find("4:3: 'foot' and 'foot_b' are "), 0U) << text;
  EXPECT_NE(text.find(" mm apart in the initial state: the loop 'ankle' is open"),
            std::string::npos)
      << text;
  const std::size_t from = text.find(says);
  ASSERT_NE(from, std::string::npos) << text;
  const std::string joints =
      text.substr(from + says.size() - 1, text.find('}', from) - from - says.size() + 2);
  std::string closed = open;
  const std::size_t at = closed.find("initial_state:");
  closed.replace(at, closed.find('\n', at) - at,
                 "initial_state: {joints: " + replaced(joints, "{", "{slide: 0.21, ") + "}");
  const Loaded again(closed);
  EXPECT_TRUE(again.built) << again.all();
}

TEST(LoopFile, GapsOfSurfacesAreLengthsAndAngles) {
  const std::string text = errors(R"(conddp: 1
robot: {urdf: robots/arm7.urdf}
loops: {hold: {frame: tool, to: link_2, type: surface}}
initial_state: {}
phases: [{knots: 3, dt: 0.01}]
costs: {effort: {residual: control}}
)");
  EXPECT_NE(text.find(" mm apart and 0 rad turned in the initial state"), std::string::npos)
      << text;
}

TEST(LoopFile, LoopsThatNothingClosesAreErrors) {
  const std::string text = errors(replaced(kLeg, "to: foot_b", "to: body"));
  EXPECT_NE(text.find("no posture was found that closes the loop"), std::string::npos) << text;
}

TEST(LoopFile, SystemsWithoutPhasesOfContactsHaveNoLoops) {
  EXPECT_NE(errors(std::string(kPendulum) + "loops: {knee: {frame: a, to: b}}\n")
                .find("a closed-form system has no frames that could be held together"),
            std::string::npos);
  std::string implicit = replaced(kLeg, "contacts:\n  ground: {frame: foot, type: planar}\n",
                                  "contact_candidates: {toe: {frame: foot}}\n");
  implicit = replaced(implicit, "contacts: ground}", "}");
  EXPECT_NE(errors(implicit).find("'contact_candidates'"), std::string::npos) << errors(implicit);
}

TEST(LoopFile, FindingsKnowBoundsAtEnds) {
  const Loaded leg(std::string(kLeg) + R"(constraints:
  reach: {bounds: configuration, from: urdf}
  speed: {bounds: velocity, from: urdf, nodes: ends}
)");
  ASSERT_TRUE(leg.built) << leg.all();
  const FindingNames names = finding_names(*leg.built);
  EXPECT_EQ(names.bounded, (std::set<std::string>{"configuration", "velocity"}));
  EXPECT_EQ(names.bounded_to_the_end, std::set<std::string>{"velocity"});
}

TEST(LoopFile, FindingsNameTheKeysOfLoops) {
  const Loaded leg{std::string(kLeg)};
  ASSERT_TRUE(leg.built) << leg.all();
  const std::map<std::string, std::string> expected = {{"ankle", "loops.ankle"}};
  EXPECT_EQ(finding_names(*leg.built).contact_keys, expected);
}

TEST(LoopFile, UselessFramesAreErrors) {
  const auto errors_with = [](const std::string& from, const std::string& to) {
    return errors(replaced(kLeg, from, to));
  };
  EXPECT_NE(errors_with("to: foot_b", "to: lower_a")
                .find("4:28: the frames 'foot' and 'lower_a' are on one body"),
            std::string::npos);
  EXPECT_NE(errors_with("frame: foot, to: foot_b", "frame: rail, to: foot")
                .find("exchange 'frame' and 'to'"),
            std::string::npos);
  EXPECT_NE(errors_with("to: foot_b", "to: foot_c").find("the robot has no frame 'foot_c'"),
            std::string::npos);
  EXPECT_NE(errors_with("  ankle:", "  ground:").find("a contact is called 'ground', too"),
            std::string::npos);
  EXPECT_NE(errors_with(", to: foot_b", "").find("'to'"), std::string::npos);
}

TEST(LoopFile, ConesCountOnContactsWithTheWorld) {
  const Loaded leg(replaced(kLeg, "costs:\n", "costs:\n  cone: {residual: friction_cone}\n"));
  ASSERT_TRUE(leg.built) << leg.all();
  const KnotModel& push = *leg.built->problem->knot(0).model;
  EXPECT_EQ(push.costs().size(), 2U);
  const Loaded named(
      replaced(kLeg, "costs:\n", "costs:\n  inner: {residual: contact_force, contacts: ankle}\n"));
  ASSERT_TRUE(named.built) << named.all();
  EXPECT_EQ(named.built->problem->knot(5).model->costs().size(), 2U);
}

/// Two arms and frames of the file.
constexpr std::string_view kArms = R"(conddp: 1
robots:
  arm: {urdf: robots/arm7.urdf, frames: {tip: {parent: tool, placement: {position: [0, 0, 0.1]}},
        end: {parent: tip, placement: {position: [0, 0.2, 0]}}}}
  box: {urdf: robots/free_body.urdf, base: floating, actuation: none}
initial_state: {robots: {arm: {joints: {joint_2: 0.4, joint_4: -1.2, joint_6: 1.54}},
                         box: {base: {position: [0.4, 0.1, 0.3], rpy: [0, 0, 1.5707963267948966]}}}}
phases: [{name: only, knots: 3, dt: 0.01}]
costs:
  away: {residual: frame_position, frame: arm/end, relative_to: box/body, reference: [0, 0, 0]}
)";

TEST(LoopFile, ResidualsSeeFramesFromOthers) {
  const Loaded arms{std::string(kArms)};
  ASSERT_TRUE(arms.built) << arms.all();
  const auto* robot = arms.built->problem->knot(0).model->system().as_multibody();
  const RobotModel& model = robot->robot();
  const auto& x = arms.built->problem->initial_state();
  RobotData<double> data(model);
  update_placements(model, x.data(), data);
  const auto place = [&](const char* frame) {
    return frame_placement(model, data, model.find_frame(frame).value());
  };
  const SE3<double> tool = place("arm/tool");
  const Vector3<double> end = tool.p + tool.R * Vector3<double>{0, 0.2, 0.1};
  const Vector3<double> way = end - Vector3<double>{0.4, 0.1, 0.3};
  KnotWorkspace<double> work(*arms.built->problem->knot(0).model);
  const KnotView& view = arms.built->problem->knot(0);
  const std::vector<double> u(view.model->nu(), 0.0);
  view.model->evaluate({x.data(), u.data(), view.parameters, view.dt, view.cost_scale}, work);
  // The box is turned by a quarter, which the distance does not see.
  EXPECT_NEAR(work.cost, 0.5 * squared_norm(way) * view.dt, 1e-9);
}

TEST(LoopFile, FramesOfTheFileHaveNewNames) {
  EXPECT_NE(
      errors(replaced(kArms, "{tip: {", "{tool: {")).find("the robot has a frame 'tool' already"),
      std::string::npos);
  EXPECT_NE(errors(replaced(kArms, "parent: tip", "parent: top")).find("no frame 'arm/top'"),
            std::string::npos);
}

}  // namespace
}  // namespace conddp
