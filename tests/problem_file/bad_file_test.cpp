#include <algorithm>
#include <fstream>

#include <fmt/format.h>

#include "problem_text.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A mistake in a problem file: the replaced text, the replacement, and the resulting message. The
/// place is marked by § in the replacement or given as "line:column: " in the message.
struct Mistake {
  const char* name;
  const char* from;
  const char* to;
  const char* error;  ///< beginning of the message
  const char* hint = "";
};

void PrintTo(const Mistake& m, std::ostream* stream) { *stream << m.name; }

/// Removes the mark from a text and returns its place as "line:column: ".
std::string take_mark(std::string& text) {
  constexpr std::string_view kMark = "§";
  const std::size_t at = text.find(kMark);
  if (at == std::string::npos) return "";
  text.erase(at, kMark.size());
  const std::size_t line_start = text.rfind('\n', at) + 1;  // npos + 1 is 0
  return fmt::format("{}:{}: ", 1 + std::count(text.begin(), text.begin() + at, '\n'),
                     at - line_start + 1);
}

void expect_mistake(std::string_view correct, const Mistake& m) {
  std::string text = replaced(correct, m.from, m.to);
  const std::string expected = take_mark(text) + m.error;
  const Loaded loaded(text);
  EXPECT_FALSE(loaded.built);
  ASSERT_TRUE(loaded.error());
  EXPECT_EQ(loaded.first_error().substr(0, expected.size()), expected);
  EXPECT_NE(loaded.error()->hint.find(m.hint), std::string::npos) << loaded.error()->hint;
}

class BadPendulum : public testing::TestWithParam<Mistake> {};
TEST_P(BadPendulum, IsNamedWithItsPlace) { expect_mistake(kPendulum, GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Keys, BadPendulum,
    testing::Values(
        Mistake{"NoFormat", "conddp: 1\n", "", "1:1: the key 'conddp' is missing"},
        Mistake{"OtherFormat", "conddp: 1", "conddp: §2", "the file has format 2"},
        Mistake{"UnknownKey", "integrator:", "§integrater:", "unknown key 'integrater'",
                "did you mean 'integrator'?"},
        Mistake{"UnknownInside", "weight: 0.5", "§wieght: 0.5",
                "unknown key 'wieght' in 'costs.effort'", "did you mean 'weight'"},
        Mistake{"WordOfAnotherTool", "bounds: control,", "bounds: control, §max: 3,",
                "unknown key 'max' in 'constraints.torque'", "did you mean 'upper'?"},
        Mistake{"FarFromAnyKey", "name: test", "§zzzzzz: test", "unknown key 'zzzzzz'",
                "accepted: conddp, name"},
        Mistake{"Contacts", "costs:\n", "contacts: §{}\ncosts:\n",
                "a closed-form system has no frames that could touch the world"},
        Mistake{"NothingMoves", "system: {type: pendulum}\n", "",
                "1:1: the file defines nothing that moves"},
        Mistake{"TwoPlants", "system: {", "robot: {urdf: x}\n§system: {",
                "'robot' and 'system' exclude each other"},
        Mistake{"NoPhases", "phases:", "x_phases:", "1:1: the key 'phases' is missing"},
        Mistake{
            "EmptyPhases",
            "phases:\n  - {name: first, knots: 4, dt: 0.1}\n  - {name: second, knots: 6, dt: 0.05}",
            "phases: §[]", "there is no phase"},
        Mistake{
            "EmptyValue",
            "phases:\n  - {name: first, knots: 4, dt: 0.1}\n  - {name: second, knots: 6, dt: 0.05}",
            "§phases:", "a list is expected here, not nothing"},
        Mistake{"BadName", "name: test", "name: §a/b", "the name is also that of a folder"},
        Mistake{"Gravity", "integrator: rk4", "gravity: §[0, 0, -9]",
                "a closed-form system has its gravity"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Values, BadPendulum,
    testing::Values(
        Mistake{"NotANumber", "weight: 0.5", "weight: §heavy",
                "a number that is not negative is expected here, and 'heavy' is not a number"},
        Mistake{"QuotedNumber", "weight: 0.5", "weight: §'0.5'",
                "a number that is not negative is expected here, not a quoted text",
                "leave the quotes out"},
        Mistake{"Infinite", "weight: 0.5", "weight: §.inf",
                "a number that is not negative is expected here, and '.inf' is not finite"},
        Mistake{"Octal", "dt: 0.1", "dt: §010",
                "a positive number is expected here, and '010' has a leading zero"},
        Mistake{"Negative", "weight: 0.5", "weight: §-1",
                "a number that is not negative is expected here, not -1"},
        Mistake{"ZeroStep", "dt: 0.1", "dt: §0", "a positive number"},
        Mistake{"NoStep", ", dt: 0.1", "", "7:5: a phase needs 'dt'"},
        Mistake{"StepAndDuration", "dt: 0.1", "dt: 0.1, §duration: 1",
                "'dt' and 'duration' exclude each other"},
        Mistake{"HalfAKnot", "knots: 4", "knots: §4.5", "a whole number from 1 to 1000000"},
        Mistake{"NoKnots", "knots: 4", "knots: §0", "a whole number"},
        Mistake{"ManyKnots", "knots: 4", "knots: §100000000", "a whole number"},
        Mistake{"ListForMap", "costs:\n  effort:", "costs: §[1]\nx:\n  effort:",
                "a mapping from names to values is expected here, not a list"},
        Mistake{"UnknownWord", "integrator: rk4", "integrator: §rk5", "unknown integrator 'rk5'",
                "did you mean 'rk2'"},
        Mistake{"UnknownSystem", "type: pendulum", "type: §pendulm",
                "unknown type of system 'pendulm'", "did you mean 'pendulum'?"},
        Mistake{"UnknownParameter", "type: pendulum", "type: pendulum, §weight: 2",
                "unknown key 'weight' in 'system'"},
        Mistake{"SamePhaseTwice", "name: second", "name: §first",
                "two phases have the name 'first'"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Costs, BadPendulum,
    testing::Values(
        Mistake{"NoResidual", "residual: control, ", "",
                "10:11: 'costs.effort' lacks the key 'residual'"},
        Mistake{"UnknownResidual", "residual: control", "residual: §controls",
                "unknown residual 'controls'", "did you mean 'control'?"},
        Mistake{"NeedsRobot", "residual: control", "residual: §joint_position",
                "the residual 'joint_position' needs a robot"},
        Mistake{"NeedsFrame", "residual: control", "residual: frame_position",
                "10:11: 'costs.effort' lacks the key 'frame'"},
        Mistake{"UnfitKey", "residual: control,", "residual: control, frame: §x,",
                "the residual 'control' has no 'frame'"},
        Mistake{"TerminalControl", "residual: state, reference: {values: {theta: 1}}",
                "residual: §control", "the residual 'control' needs a control"},
        Mistake{"TerminalPhases", "weight: 10", "weight: 10, §phases: [first]",
                "unknown key 'phases'"},
        Mistake{"UnknownPhase", "weight: 0.5", "weight: 0.5, phases: [§frist]",
                "unknown phase 'frist'", "did you mean 'first'?"},
        Mistake{"KnotBeyond", "weight: 0.5", "weight: 0.5, knots: [3, §10]",
                "running knots are numbered from 0 to 9"},
        Mistake{"UnknownColumn", "theta: 1}", "§tehta: 1}", "the state has no column 'tehta'",
                "did you mean 'theta'?"},
        Mistake{"ShortState", "{values: {theta: 1}}", "§[1]",
                "a list of 2 numbers, one for each of the columns of the state, is expected here; "
                "this one has 1",
                "theta, omega"},
        Mistake{"NumberForState", "{values: {theta: 1}}", "§1", "one number is not a state"},
        Mistake{"NameForState", "{values: {theta: 1}}", "§upright", "unknown state 'upright'"},
        Mistake{"Activation", "weight: 0.5", "activation: §quadratc",
                "unknown activation 'quadratc'", "did you mean 'quadratic'?"},
        Mistake{"BarrierWithoutBounds", "weight: 0.5", "activation: §quadratic_barrier",
                "a barrier needs its bounds"},
        Mistake{"BoundsWithoutBarrier", "weight: 0.5", "activation: {kind: quadratic, lower: §0}",
                "bounds belong to the activation 'quadratic_barrier'"},
        Mistake{"EmptyBarrier", "weight: 0.5",
                "activation: §{kind: quadratic_barrier, lower: 2, upper: 1}",
                "for 'torque' the lower bound 2 lies above the upper bound 1"},
        Mistake{"Weights", "weight: 0.5", "weights: §[1, 2]",
                "a list of 1 number, one for each of the controls, is expected here"},
        Mistake{"WeightsName", "weight: 0.5", "weights: {§torqe: 1}",
                "'torqe' fits none of the controls", "did you mean 'torque'?"},
        Mistake{"NegativeWeights", "weight: 0.5", "weights: [§-1]",
                "a number that is not negative"},
        Mistake{"PhaseWeight", "dt: 0.1}", "dt: 0.1, weights: {§efort: 2}}", "unknown cost 'efort'",
                "did you mean 'effort'?"},
        Mistake{"WayPointsCount", "{values: {theta: 1}}", "{times: [0, 1], values: §[initial]}",
                "there are 1 values for 2 times"},
        Mistake{"WayPointsOrder", "{values: {theta: 1}}",
                "{times: [1, §0], values: [initial, initial]}", "the times must increase"}),
    [](const auto& test) { return test.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Rest, BadPendulum,
    testing::Values(
        Mistake{"OtherConstraint", "bounds: control", "bounds: §force",
                "unknown quantity that can have bounds 'force'",
                "accepted: control, state, configuration, velocity"},
        Mistake{"NoBounds", "bounds: control, lower: -3, upper: 3", "upper: 3",
                "12:11: the constraint 'torque' lacks the key 'residual' or 'bounds'"},
        Mistake{"NoLimits", ", lower: -3, upper: 3", "", "12:11: the bounds 'torque' need"},
        Mistake{"FromUrdf", "lower: -3, upper: 3", "from: §urdf",
                "a closed-form system has no URDF"},
        Mistake{"Contradiction", "upper: 3", "upper: -4",
                "12:3: no value of 'torque' satisfies the bounds"},
        Mistake{"UnknownSolver", "box_ddp", "§box_dpp", "unknown solver 'box_dpp'",
                "did you mean 'box_ddp'"},
        Mistake{"UnknownOption", "name: box_ddp", "name: box_ddp, §max_iteration: 5",
                "unknown key 'max_iteration' in 'solver'", "did you mean 'max_iterations'?"},
        Mistake{"UnknownTolerance", "name: box_ddp", "tolerances: {§stationary: 1}",
                "unknown key 'stationary' in 'solver.tolerances'"},
        Mistake{"OptionRange", "name: box_ddp", "tolerances: {gap: §-1}",
                "tolerances.gap must be > 0"},
        Mistake{"OptionWord", "name: box_ddp",
                "name: box_fddp, complementarity: {relaxation: §none}",
                "unknown value of 'complementarity.relaxation' 'none'",
                "accepted: elementwise, inner_product, fischer_burmeister, penalty"},
        Mistake{"Perturbation", "solver:", "perturbation: {initial_state: §-0.1}\nsolver:",
                "a number from 0 to 1e6"},
        Mistake{"PerturbationSeed",
                "solver:", "perturbation: {seed: §0.5}\nsolver:", "a whole number"},
        Mistake{"GuessWord", "solver:", "initial_guess: {states: §zero}\nsolver:",
                "unknown way to guess states 'zero'"},
        Mistake{"GuessFile", "solver:", "initial_guess: {file: §absent.json}\nsolver:", ""},
        Mistake{"Interpolate",
                "terminal:\n  costs:\n    goal: {residual: state, reference: {values: {theta: 1}}, "
                "weight: 10}",
                "initial_guess: {states: §interpolate}", "to interpolate"},
        Mistake{"KeyframeOrder", "solver:",
                "initial_guess: {states: {keyframes: [{knot: 3, state: [0, 0]}, §{knot: 3, state: "
                "[1, 0]}]}}\nsolver:",
                "keyframes must stand in the order of time"},
        Mistake{"KeyframeBeyond", "solver:",
                "initial_guess: {states: {keyframes: [{knot: §11, state: [0, 0]}]}}\nsolver:",
                "nodes are numbered from 0 to 10"},
        Mistake{"PreviousControl", "{theta: 0.1}}", "{theta: 0.1}, previous_control: §1}",
                "'previous_control' serves 'control_rate', 'previous' and linear controls only"},
        Mistake{"StateTwice", "{values: {theta: 0.1}}", "{values: {theta: 0.1}, §state: [0, 0]}",
                "'values' and 'state' exclude each other"},
        Mistake{"LongState", "{values: {theta: 0.1}}", "§{state: [0, 0, 0]}",
                "the state has 2 numbers, not 3"},
        Mistake{"Joints", "{values: {theta: 0.1}}", "§{joints: {hip: 1}}",
                "a closed-form system has no configurations"}),
    [](const auto& test) { return test.param.name; });

class BadCartpole : public testing::TestWithParam<Mistake> {};
TEST_P(BadCartpole, IsNamedWithItsPlace) { expect_mistake(kCartpole, GetParam()); }

INSTANTIATE_TEST_SUITE_P(
    Robot, BadCartpole,
    testing::Values(
        Mistake{"NoFile", "cartpole.urdf", "cartpol.urdf", "3:9: "},
        Mistake{"NoUrdf", "  urdf: robots/cartpole.urdf\n", "",
                "3:3: 'robot' lacks the key 'urdf'"},
        Mistake{"Actuation", "joints: [slider]", "joints: [§slidr]",
                "the robot has no joint 'slidr'", "did you mean 'slider'?"},
        Mistake{"FixedJoint", "joints: [slider]", "joints: [§tip_mount]",
                "the joint 'tip_mount' does not move"},
        Mistake{"ActuatedTwice", "joints: [slider]", "joints: [slider, §slider]",
                "'slider' stands twice in the list"},
        Mistake{"JointTwice", "phases:",
                "costs: {c: {residual: joint_position, joints: [hinge, §hinge]}}\nphases:",
                "'hinge' stands twice in the list"},
        Mistake{"ColumnTwice",
                "phases:", "costs: {c: {residual: state, columns: [q/hinge, §q/hinge]}}\nphases:",
                "'q/hinge' stands twice in the list"},
        Mistake{"ColumnPattern",
                "phases:", "costs: {c: {residual: state, columns: [§vel*]}}\nphases:",
                "the state has no column 'vel*'"},
        Mistake{
            "FileColumnTwice", "phases:",
            "costs: {c: {residual: state, reference: {file: a.csv, columns: [a, §a]}}}\nphases:",
            "'a' stands twice in the list"},
        Mistake{"PhaseTwice",
                "phases:", "costs: {c: {residual: control, phases: [only, §only]}}\nphases:",
                "'only' stands twice in the list"},
        Mistake{"BoundedPhaseTwice", "phases:",
                "constraints: {c: {bounds: control, upper: 1, phases: [only, §only]}}\nphases:",
                "'only' stands twice in the list"},
        Mistake{"KnotTwice",
                "phases:", "costs: {c: {residual: control, knots: [1, 2, §1]}}\nphases:",
                "1 stands twice in the list"},
        Mistake{"ActuationWord", "{joints: [slider]}", "§partial", "unknown actuation 'partial'"},
        Mistake{"Thruster", "{joints: [slider]}", "{thrusters: [{name: a, frame: §tip}]}",
                "the thruster's frame 'tip' is not fixed to a floating base"},
        Mistake{"Configuration", "configuration: up", "configuration: §upp",
                "unknown configuration 'upp'", "did you mean 'up'?"},
        Mistake{"ConfigurationJoint", "{hinge: 3}", "{§hing: 3}", "the robot has no joint 'hing'",
                "did you mean 'hinge'?"},
        Mistake{"ConfigurationPattern", "{hinge: 3}", "{§'*_knee': 3}",
                "'*_knee' fits none of the joints", "joints: slider, hinge"},
        Mistake{"ConfigurationVelocity", "{hinge: 3}}",
                "{hinge: 3}, velocity: {joints: {hinge: 1}}}",
                "6:9: a configuration has 'base', 'joints' and 'frames' only"},
        Mistake{"InitialAsName", "    up:", "    §initial:", "'initial' means the initial state"},
        Mistake{"Base", "{configuration: up}", "{base: §{position: [0, 0, 1]}}",
                "the robot's base is fixed"},
        Mistake{"LockedJoint", "actuation:", "locked_joints: {§hinj: 0}\n  actuation:", ""},
        Mistake{"LockedPattern", "actuation:", "locked_joints: {§arm_*: 0}\n  actuation:", ""},
        Mistake{"Payload", "actuation:", "payloads: {§pol: {mass: 1}}\n  actuation:", ""},
        Mistake{"PayloadMass",
                "actuation:", "payloads: {pole: {mass: §0}}\n  actuation:", "a positive number"},
        Mistake{"Wrench", "actuation:", "external_wrenches: [{frame: §tipp}]\n  actuation:",
                "the robot has no frame 'tipp'", "did you mean 'tip'?"},
        Mistake{"Quaternion", "actuation:", "placement: {orientation: §[0, 0, 0, 2]}\n  actuation:",
                "the quaternion has length 2, not 1"},
        Mistake{"TwoRotations", "actuation:",
                "placement: {orientation: [0, 0, 0, 1], §rpy: [0, 0, 0]}\n  actuation:",
                "'orientation' and 'rpy' exclude each other"},
        Mistake{"FrameCost", "phases:",
                "costs: {c: {residual: frame_position, frame: §tpi, reference: initial}}\nphases:",
                "the robot has no frame 'tpi'", "did you mean 'tip'?"},
        Mistake{"FrameWithoutReference",
                "phases:", "costs: {§c: {residual: frame_position, frame: tip}}\nphases:",
                "'c' needs a reference"},
        Mistake{"PoseWithoutPosition", "phases:",
                "costs: {c: {residual: frame_placement, frame: tip, reference: §{rpy: [0, 0, "
                "0]}}}\nphases:",
                "the reference lacks 'position'"},
        Mistake{"JointCost",
                "phases:", "costs: {c: {residual: joint_position, joints: §hing}}\nphases:",
                "the robot has no joint 'hing'"},
        Mistake{"Robots", "{configuration: up}", "{robots: {§arm: {configuration: up}}}",
                "unknown robot 'arm'"}),
    [](const auto& test) { return test.param.name; });

TEST(BadFile, SeveralErrorsAreReportedTogether) {
  std::string text = replaced(kPendulum, "knots: 4", "knots: x");
  text = replaced(text, "weight: 0.5", "wight: 0.5");
  text = replaced(text, "name: box_ddp", "names: box_ddp");
  const Loaded loaded(text);
  EXPECT_EQ(loaded.diagnostics.error_count(), 3) << loaded.all();
}

TEST(BadFile, BuildErrorsAreReportedTogether) {
  std::string text = replaced(kPendulum, "theta: 1}", "thta: 1}");
  text = replaced(text, "weight: 0.5", "phases: [thrid]");
  text = replaced(text, "name: box_ddp", "name: boxddp");
  EXPECT_EQ(Loaded(text).diagnostics.error_count(), 3) << Loaded(text).all();
}

TEST(BadFile, ReportsAnErrorOnce) {
  const std::string still = replaced(
      kPendulum,
      "terminal:", "  still: {residual: state, columns: [theta], equals: {z: 1}}\nterminal:");
  EXPECT_EQ(Loaded(still).diagnostics.list().size(), 1u);
  const std::string contacts = replaced(kPendulum, "dt: 0.05", "dt: 0.05, contacts: [foot]");
  EXPECT_EQ(Loaded(contacts).diagnostics.list().size(), 1u);
}

TEST(BadFile, AcceptedWordsAreData) {
  const Loaded loaded(replaced(kPendulum, "rk4", "euler"));
  ASSERT_TRUE(loaded.error());
  EXPECT_EQ(loaded.error()->path, "integrator");
  EXPECT_EQ(loaded.error()->accepted.size(), 10u);
}

TEST(BadFile, DropsNothingTwice) {
  const Loaded loaded(std::string(kPendulum), {}, {.drop = {"torque", "torque"}});
  ASSERT_TRUE(loaded.error());
  EXPECT_EQ(loaded.error()->message, "--drop torque stands twice on the command line");
}

/// A hinge and a mimic joint, with limits.
std::string mimic_urdf(const std::string& follower_limits) {
  const std::string link =
      "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' "
      "ixz='0' iyz='0'/></inertial></link>";
  const auto hinge = [](const std::string& name, const std::string& child,
                        const std::string& rest) {
    return "<joint name='" + name + "' type='revolute'><parent link='base'/><child link='" + child +
           "'/><axis xyz='0 0 1'/>" + rest + "</joint>";
  };
  return "<robot name='gripper'><link name='base'/><link name='a'>" + link + "<link name='b'>" +
         link + hinge("leader", "a", "<limit lower='0.5' upper='1' effort='1' velocity='1'/>") +
         hinge(
             "follower", "b",
             "<limit " + follower_limits +
                 " effort='1' velocity='1'/><mimic joint='leader' multiplier='-2' offset='0.1'/>") +
         "</robot>";
}

TEST(BadFile, IncompatibleMimicLimitsNameBothJoints) {
  const TemporaryFolder folder;
  const auto load = [&](const std::string& limits, const std::string& mimic) {
    std::ofstream(folder / "gripper.urdf") << mimic_urdf(limits);
    return Loaded("conddp: 1\nrobot: {urdf: " + (folder / "gripper.urdf").string() +
                  ", mimic: " + mimic + "}\ninitial_state: {}\nphases: [{knots: 2, dt: 0.1}]\n");
  };
  // The follower moves from -0.9 (leader at 0.5) to -1.9 (leader at 1).
  EXPECT_TRUE(load("lower='-1.5' upper='0'", "enforce").built);
  EXPECT_TRUE(load("lower='0' upper='1'", "ignore").built);
  const Loaded wrong = load("lower='0' upper='1'", "enforce");
  EXPECT_FALSE(wrong.built);
  EXPECT_TRUE(wrong.first_error().starts_with(
      "2:8: no position of the joint 'leader' (limits 0.5 to 1) satisfies the limits 0 to 1 of the "
      "joint 'follower', which mimics it"))
      << wrong.all();
}

TEST(BadFile, UnknownDroppedConstraintGetsASuggestion) {
  const Loaded loaded(std::string(kPendulum), {}, {.drop = {"torqe"}});
  ASSERT_TRUE(loaded.error());
  EXPECT_NE(loaded.error()->message.find("unknown constraint 'torqe'"), std::string::npos);
  EXPECT_EQ(loaded.error()->hint, "did you mean 'torque'?");
}

}  // namespace
}  // namespace conddp
