// Inverse kinematics of states: `frames` places frames of a robot, and joint positions follow.
#include <cmath>

#include <Eigen/Dense>

#include "problem_file/plant/posture.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

/// Two rods of 0.5 and 0.4 m; both joints turn about −y.
std::string pendulum_with(const std::string& initial_state) {
  return "conddp: 1\nrobot: {urdf: robots/double_pendulum.urdf}\ninitial_state: " + initial_state +
         "\nphases: [{knots: 3, dt: 0.02}]\ncosts: {effort: {residual: control}}\n";
}

std::string arm_with(const std::string& initial_state, const std::string& more = "") {
  return "conddp: 1\nrobot:\n  urdf: robots/arm7.urdf\n  configurations:\n"
         "    ready: {joints: {joint_2: 0.4, joint_4: -1.2, joint_6: 1.54}}\n"
         "    there: {joints: {joint_2: 0.4, joint_4: -1.2, joint_6: 1.54}, frames: {tool: "
         "{position: "
         "[0.5, -0.2, 0.3], rpy: [3.1416, 0, 0]}}}\n"
         "initial_state: " +
         initial_state +
         "\nphases: [{knots: 3, dt: 0.02}]\ncosts: {effort: {residual: control}}\n" + more;
}

std::vector<double> start_of(const Loaded& loaded) {
  const auto x = loaded.built->problem->initial_state();
  return {x.begin(), x.end()};
}

SE3<double> frame_of(const Loaded& loaded, const char* frame) {
  const MultibodySystem& system = *loaded.built->plant.multibody();
  return placement_in_state(system, start_of(loaded), *system.robot().find_frame(frame));
}

TEST(PlacedFrames, TwoRodsMeetTheLawOfCosines) {
  const double x = 0.3, z = -0.6, distance = std::hypot(x, z);
  const double bend = std::acos((distance * distance - 0.25 - 0.16) / (2 * 0.5 * 0.4));
  for (const double side : {1.0, -1.0}) {
    const Loaded loaded(pendulum_with(fmt::format(
        "{{joints: {{elbow: {}}}, frames: {{tip: {{position: [{}, 0, {}]}}}}}}", side, x, z)));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const double elbow = side * bend;
    const double shoulder =
        std::atan2(x, -z) - std::atan2(0.4 * std::sin(elbow), 0.5 + 0.4 * std::cos(elbow));
    EXPECT_NEAR(start_of(loaded)[0], shoulder, 1e-6);
    EXPECT_NEAR(start_of(loaded)[1], elbow, 1e-6);
  }
}

TEST(PlacedFrames, RotationsAndPlacementsAreMet) {
  const Loaded placed(arm_with("{configuration: there}"));
  ASSERT_TRUE(placed.built) << placed.all();
  const SE3<double> tool = frame_of(placed, "tool");
  EXPECT_NEAR(std::sqrt(squared_norm(tool.p - Vector3<double>{0.5, -0.2, 0.3})), 0, 1e-6);
  const Loaded turned(arm_with("{configuration: ready, frames: {tool: {rpy: [1.5708, 0, 0.3]}}}"));
  ASSERT_TRUE(turned.built) << turned.all();
  const Matrix3<double> error =
      transpose(rotation_rpy(1.5708, 0.0, 0.3)) * frame_of(turned, "tool").R;
  EXPECT_NEAR(squared_norm(log_so3(quaternion(error))), 0, 1e-12);
}

/// Motion of a position-only goal along directions that leave the hand where it is, and the motion.
std::pair<double, double> wasted_motion(const Vector3<double>& goal) {
  const Loaded loaded(arm_with("{configuration: ready}"));
  const std::shared_ptr<const MultibodySystem> system = loaded.built->plant.multibody();
  const int tool = *system->robot().find_frame("tool");
  const std::vector<int> joints = movable_joints(*system, 0, system->robot().joint_count());
  const std::vector<double> start = start_of(loaded);
  const Posture posture = find_posture(
      *system, {{frame_position_residual(system, tool), {goal.x, goal.y, goal.z}}}, joints, start);
  EXPECT_TRUE(posture.found());
  Eigen::MatrixXd jacobian(3, joints.size());
  Eigen::VectorXd motion(joints.size());
  for (std::size_t i = 0; i < joints.size(); ++i) {
    const int at = *system->position_index(joints[i]);
    motion[i] = posture.x[at] - start[at];
    std::vector<double> up = posture.x, down = posture.x;
    up[at] += 1e-6, down[at] -= 1e-6;
    const Vector3<double> d =
        placement_in_state(*system, up, tool).p - placement_in_state(*system, down, tool).p;
    jacobian.col(i) << d.x / 2e-6, d.y / 2e-6, d.z / 2e-6;
  }
  const Eigen::VectorXd needed =
      jacobian.completeOrthogonalDecomposition().solve(jacobian * motion);
  return {(motion - needed).norm(), motion.norm()};
}

TEST(PlacedFrames, RedundantArmsMoveAsLittleAsPossible) {
  for (const Vector3<double>& goal :
       {Vector3<double>{0.5, -0.2, 0.3}, {0.2, 0.5, 0.6}, {0.45, 0.1, 0.8}}) {
    const auto [wasted, motion] = wasted_motion(goal);
    EXPECT_GT(motion, 0.1);
    EXPECT_LT(wasted, 1e-3 * motion);
  }
}

TEST(PlacedFrames, JointsKeepTheirLimits) {
  // Upright, the hand may turn only with the joints at their limits.
  const Loaded loaded(arm_with("{frames: {tool: {position: [-0.4, 0.3, 0.5]}}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.all().find("warning"), std::string::npos) << loaded.all();
  const MultibodySystem& system = *loaded.built->plant.multibody();
  for (const int joint : movable_joints(system, 0, system.robot().joint_count())) {
    const double q = start_of(loaded)[*system.position_index(joint)];
    EXPECT_GE(q, system.limits(joint).lower);
    EXPECT_LE(q, system.limits(joint).upper);
  }
}

TEST(PlacedFrames, ShapesOfDistancesKeepApart) {
  // The ball lies where the elbow would be; with the elbow on the other side, the rods pass it.
  const std::string ball =
      "collision:\n  shapes:\n    upper: {frame: upper_rod, capsule: {radius: 0.02, to: [0, 0, "
      "-0.5]}}\n    lower: {frame: lower_rod, capsule: {radius: 0.02, to: [0, 0, -0.4]}}\n"
      "  obstacles: {ball: {sphere: {center: [0.4, 0, -0.3], radius: 0.1}}}\n"
      "constraints: {clear: {residual: distance, pairs: obstacles, margin: 0.02}}\n";
  const std::string file = pendulum_with(
      "{joints: {shoulder: 0.9, elbow: -0.9}, "
      "frames: {tip: {position: [0.3, 0, -0.6]}}}");
  const Loaded free(file), blocked(file + ball);
  ASSERT_TRUE(free.built) << free.all();
  ASSERT_TRUE(blocked.built) << blocked.all();
  EXPECT_LT(std::sin(start_of(free)[1]), 0);
  EXPECT_GT(std::sin(start_of(blocked)[1]), 0);
  EXPECT_LT(std::abs(start_of(blocked)[1]), M_PI) << "no more than the way around";
}

TEST(PlacedFrames, LoopsClose) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/five_bar_leg.urdf, actuation: {joints: [hip_a, hip_b]}}
loops:
  ankle: {frame: foot, to: foot_b, type: planar, tangent: [1, 0, 0]}
initial_state:
  joints: {hip_a: 1, knee_a: -1.8, hip_b: -1, knee_b: 1.8}
  frames: {foot: {position: [0.05, 0, 0]}}
phases: [{knots: 3, dt: 0.01}]
costs: {effort: {residual: control}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Vector3<double> foot = frame_of(loaded, "foot").p;
  EXPECT_LT(squared_norm(foot - frame_of(loaded, "foot_b").p), 1e-12);
  EXPECT_LT(squared_norm(foot - Vector3<double>{0.05, 0, 0}), 1e-12);
}

TEST(PlacedFrames, BasesStay) {
  const Loaded loaded(kStandingQuadruped +
                          "phases: [{knots: 3, dt: 0.02, contacts: all}]\n"
                          "costs: {effort: {residual: control}}\n",
                      {"initial_state.frames={lf_foot: {position: [0.4, 0.2, 0.1]}}"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double> x = start_of(loaded);
  EXPECT_EQ(std::vector(x.begin(), x.begin() + 3), (std::vector{0.0, 0.0, 0.57}));
}

TEST(PlacedFrames, SeveralRobotsPlaceTheirOwn) {
  const Loaded loaded(R"(conddp: 1
robots:
  left: {urdf: robots/double_pendulum.urdf}
  right: {urdf: robots/double_pendulum.urdf, placement: {position: [1, 0, 0]}}
initial_state:
  robots:
    left: {joints: {elbow: 0.5}}
    right: {joints: {elbow: 0.5}, frames: {tip: {position: [1.3, 0, -0.6]}}}
phases: [{knots: 3, dt: 0.02}]
costs: {effort: {residual: control}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double> x = start_of(loaded);
  EXPECT_EQ(x[0], 0);
  EXPECT_EQ(x[1], 0.5);
  EXPECT_NE(x[2], 0);
}

TEST(PlacedFrames, RobotsAndLoopsAreSolvedTogether) {
  // Two arms hold a bar by its ends; only one hand is placed, and the other loop moves the other
  // arm.
  const std::string arm = ": {urdf: robots/arm7.urdf, placement: {position: [0, ";
  const std::string state = ": {joints: {joint_2: 0.4, joint_4: -1.2, joint_6: 1.54}";
  for (const bool bar_first : {true, false}) {
    const std::string bar =
        "  bar: {urdf: robots/beam.urdf, base: floating, actuation: none, frames: {a: {parent: "
        "body, "
        "placement: {position: [0.35, 0, 0.05]}}, b: {parent: body, placement: {position: [-0.35, "
        "0, "
        "0.05]}}}}\n";
    const std::string arms = "  left" + arm + "0.35, 0]}}\n  right" + arm + "-0.35, 0]}}\n";
    const Loaded loaded(
        "conddp: 1\nrobots:\n" + (bar_first ? bar + arms : arms + bar) +
        "loops:\n  one: {frame: left/tool, to: bar/a}\n  two: {frame: right/tool, to: bar/b}\n"
        "initial_state:\n  robots:\n    left" +
        state + ", frames: {tool: {position: [0.55, 0.35, 0.6]}}}\n    right" + state +
        "}\n    bar: {base: {position: [0.55, 0, 0.55], rpy: [0, 0, 1.5707963267948966]}}\n"
        "phases: [{knots: 3, dt: 0.02}]\ncosts: {effort: {residual: control}}\n");
    EXPECT_TRUE(loaded.built) << loaded.all();
  }
}

TEST(PlacedFrames, KeyframesAndReferencesMayPlaceThem) {
  const Loaded loaded(
      arm_with("{configuration: ready}",
               "terminal: {costs: {end: {residual: state, reference: there}}}\n"
               "initial_guess: {states: {keyframes: [{knot: 3, state: {configuration: ready, "
               "frames: {tool: {position: [0.5, -0.2, 0.3], rpy: [3.1416, 0, 0]}}}}]}}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Loaded there(arm_with("{configuration: there}"));
  const auto last = loaded.built->guess.x(3);
  for (int i = 0; i < 7; ++i) EXPECT_NEAR(last[i], start_of(there)[i], 1e-9);
}

TEST(PlacedFrames, UnreachablePlacesAreErrors) {
  const Loaded far(pendulum_with("{frames: {tip: {position: [0, 0, -1.1]}}}"));
  EXPECT_FALSE(far.built);
  EXPECT_EQ(far.first_error(),
            "3:26: no joint positions were found that put 'tip' there: it stays 0.2 m away");
  const Loaded side(pendulum_with("{frames: {tip: {position: [0, 0.3, -0.9], rpy: [0, 0, 0]}}}"));
  EXPECT_NE(side.first_error().find("it stays 0.3 m and "), std::string::npos)
      << side.first_error();
}

TEST(PlacedFrames, ErrorsNameOpenLoopsAndShapes) {
  const Loaded open(R"(conddp: 1
robot: {urdf: robots/five_bar_leg.urdf}
loops: {ankle: {frame: foot, to: body}}
initial_state: {frames: {foot: {position: [0.05, 0, 0]}}}
phases: [{knots: 3, dt: 0.01}]
costs: {effort: {residual: control}}
)");
  EXPECT_NE(open.first_error().find(" away, and the loop 'ankle' open by "), std::string::npos)
      << open.first_error();
  const Loaded blocked(pendulum_with("{frames: {tip: {position: [0.3, 0, -0.6]}}}") +
                       "collision:\n  shapes: {tip: {frame: tip, sphere: {radius: 0.02}}}\n"
                       "  obstacles: {ball: {sphere: {center: [0.3, 0, -0.6], radius: 0.1}}}\n"
                       "constraints: {clear: {residual: distance, pairs: obstacles, margin: 0}}\n");
  EXPECT_NE(blocked.first_error().find(" away, and shapes too near by "), std::string::npos)
      << blocked.first_error();
}

TEST(PlacedFrames, GraspsOfSomePhasesDoNotBindThem) {
  const Loaded loaded(R"(conddp: 1
robots:
  arm: {urdf: robots/arm7.urdf}
  crate: {urdf: robots/crate.urdf, base: floating, actuation: none}
contacts:
  ground: {frame: crate/body, type: surface}
  grasp: {frame: arm/tool, to: crate/handle, baumgarte: {kp: 100, kd: 20},
          placement: {position: [0, 0, 0]}}
initial_state:
  robots:
    arm: {joints: {joint_2: 0.4, joint_4: -1.2}, frames: {tool: {position: [0.5, 0.3, 0.5]}}}
    crate: {base: {position: [0.55, -0.2, 0.1]}}
phases:
  - {name: before, knots: 3, dt: 0.02, contacts: ground}
  - {name: held, knots: 3, dt: 0.02, contacts: grasp}
costs: {effort: {residual: control}}
)");
  EXPECT_TRUE(loaded.built) << loaded.all();
}

TEST(PlacedFrames, PlanarBasesStay) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/hopper.urdf, base: planar, placement: {rpy: [1.5707963267948966, 0, 0]}}
initial_state:
  base: {position: [-0.023, 0.4583]}
  joints: {hip: 0.75, knee: -1.4}
  frames: {foot: {position: [0.05, 0, 0.03]}}
phases: [{knots: 3, dt: 0.02}]
costs: {effort: {residual: control}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double> x = start_of(loaded);
  EXPECT_EQ(std::vector(x.begin(), x.begin() + 3), (std::vector{-0.023, 0.4583, 0.0}));
  EXPECT_LT(squared_norm(frame_of(loaded, "foot").p - Vector3<double>{0.05, 0, 0.03}), 1e-12);
}

TEST(PlacedFrames, StatesReplaceFramesOfTheirConfiguration) {
  const Loaded loaded(
      arm_with("{configuration: there, frames: {tool: {position: [0.4, 0.2, 0.5]}}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_LT(squared_norm(frame_of(loaded, "tool").p - Vector3<double>{0.4, 0.2, 0.5}), 1e-12);
}

TEST(PlacedFrames, BadKeysAreErrors) {
  const auto error = [](const std::string& state) {
    return Loaded(pendulum_with(state)).first_error();
  };
  EXPECT_EQ(error("{frames: {tips: {position: [0, 0, -0.9]}}}"),
            "3:26: the robot has no frame 'tips'");
  EXPECT_NE(error("{frames: {tip: {}}}").find("a placed frame has a position"), std::string::npos);
  EXPECT_NE(error("{values: {q/elbow: 1}, frames: {tip: {position: [0, 0, -0.9]}}}").find("values"),
            std::string::npos);
}

}  // namespace
}  // namespace conddp
