#include <cmath>

#include <Eigen/Core>
#include <gtest/gtest.h>

#include "robot/model.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/simple_kinematics.hpp"
#include "urdf_text.hpp"

namespace conddp {
namespace {

constexpr double kPi = 3.14159265358979323846;

const char* const kOrigin = R"(<origin xyz="0.1 -0.2 0.3" rpy="0.4 -0.5 0.6"/>)";

RobotModel built(const std::string& xml, const UrdfOptions& options = {}) {
  UrdfResult result = parse_urdf(xml, "robot.urdf", options);
  for (const UrdfProblem& problem : result.problems)
    EXPECT_TRUE(problem.warning) << problem.message;
  if (!result.model) throw std::runtime_error("no model");
  return std::move(*result.model);
}

std::vector<std::string> joint_names(const RobotModel& model) {
  std::vector<std::string> names;
  for (const Joint& j : model.joints) names.push_back(j.name);
  return names;
}

void expect_equal(const SE3<double>& a, const SE3<double>& b, double tolerance = 1e-15) {
  for (int i = 0; i < 9; ++i) EXPECT_NEAR(a.R.m[i], b.R.m[i], tolerance);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a.p[i], b.p[i], tolerance);
}

void expect_equal(const Inertia<double>& a, const Inertia<double>& b) {
  EXPECT_NEAR(a.mass, b.mass, 1e-14);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(a.moment[i], b.moment[i], 1e-14);
  EXPECT_NEAR(a.rotational.xx, b.rotational.xx, 1e-14);
  EXPECT_NEAR(a.rotational.xy, b.rotational.xy, 1e-14);
  EXPECT_NEAR(a.rotational.xz, b.rotational.xz, 1e-14);
  EXPECT_NEAR(a.rotational.yy, b.rotational.yy, 1e-14);
  EXPECT_NEAR(a.rotational.yz, b.rotational.yz, 1e-14);
  EXPECT_NEAR(a.rotational.zz, b.rotational.zz, 1e-14);
}

std::string problem_with(const UrdfResult& result, const std::string& fragment) {
  for (const UrdfProblem& problem : result.problems)
    if (problem.message.find(fragment) != std::string::npos) return problem.element;
  return "(none)";
}
bool has_note(const UrdfResult& result, const std::string& fragment) {
  for (const std::string& note : result.notes)
    if (note.find(fragment) != std::string::npos) return true;
  return false;
}

TEST(UrdfOrder, IsDepthFirstByNameThroughFixedJoints) {
  const RobotModel model = built(robot_element(
      link_element("root") + link_element("z") + link_element("a") + link_element("m") +
      link_element("under_m") + link_element("under_a") +
      joint_element("c_z", "continuous", "root", "z") + joint_element("b_m", "fixed", "root", "m") +
      joint_element("z_under_m", "continuous", "m", "under_m") +
      joint_element("a_a", "continuous", "root", "a") +
      joint_element("x_under_a", "continuous", "a", "under_a")));
  EXPECT_EQ(joint_names(model), (std::vector<std::string>{"a_a", "x_under_a", "z_under_m", "c_z"}));
  EXPECT_EQ(model.joints[1].parent, 0);
  EXPECT_EQ(model.joints[2].parent, -1);
}

TEST(UrdfAxes, CoordinateAxesTurnToZWithoutRounding) {
  for (const char* axis : {"1 0 0", "0 1 0", "0 0 1", "-1 0 0", "0 -1 0", "0 0 -1", "0 -2 0"}) {
    const RobotModel model = built(robot_element(
        link_element("a") + link_element("b") +
        joint_element("j", "continuous", "a", "b", std::string("<axis xyz=\"") + axis + "\"/>")));
    for (const double element : model.joints[0].placement.R.m)
      EXPECT_TRUE(element == 0 || element == 1 || element == -1) << axis;
    expect_equal(simple_frame_placement(model, {0}, "b"), SE3<double>::identity(), 0);
  }
}

TEST(UrdfAxes, MoveTheLinkAlongTheFileAxis) {
  const double q = 0.7;
  const double n = std::sqrt(0.04 + 0.09 + 0.36);
  const Vector3<double> axis{0.2 / n, -0.3 / n, -0.6 / n};
  const std::string tag = "<axis xyz=\"0.2 -0.3 -0.6\"/>";
  const std::string limit = "<limit lower=\"-1\" upper=\"1\" effort=\"5\" velocity=\"6\"/>";
  const RobotModel turning =
      built(robot_element(link_element("a") + link_element("b") +
                          joint_element("j", "revolute", "a", "b", tag + limit)));
  const Quaternion<double> half{axis.x * std::sin(q / 2), axis.y * std::sin(q / 2),
                                axis.z * std::sin(q / 2), std::cos(q / 2)};
  expect_equal(simple_frame_placement(turning, {q}, "b"),
               {rotation_matrix(half), Vector3<double>::zero()});
  EXPECT_EQ(turning.joints[0].lower, -1);
  EXPECT_EQ(turning.joints[0].upper, 1);
  EXPECT_EQ(turning.joints[0].max_effort, 5);
  EXPECT_EQ(turning.joints[0].max_velocity, 6);
  const RobotModel sliding =
      built(robot_element(link_element("a") + link_element("b") +
                          joint_element("j", "prismatic", "a", "b", tag + limit)));
  expect_equal(simple_frame_placement(sliding, {q}, "b"), {Matrix3<double>::identity(), q * axis});
}

// Axes in coordinate planes are not coordinate axes.
TEST(UrdfAxes, MayHaveOneZeroComponent) {
  for (const auto& [text, axis] :
       std::vector<std::pair<const char*, Vector3<double>>>{{"0.6 0 0.8", {0.6, 0, 0.8}},
                                                            {"0.6 0 -0.8", {0.6, 0, -0.8}},
                                                            {"0 -0.6 0.8", {0, -0.6, 0.8}},
                                                            {"0 0.6 -0.8", {0, 0.6, -0.8}},
                                                            {"0.6 0.8 0", {0.6, 0.8, 0}},
                                                            {"-0.6 0.8 0", {-0.6, 0.8, 0}}}) {
    const RobotModel model = built(robot_element(
        link_element("a") + link_element("b") +
        joint_element("j", "continuous", "a", "b", std::string("<axis xyz=\"") + text + "\"/>")));
    const double q = 0.7;
    const Quaternion<double> half{axis.x * std::sin(q / 2), axis.y * std::sin(q / 2),
                                  axis.z * std::sin(q / 2), std::cos(q / 2)};
    expect_equal(simple_frame_placement(model, {q}, "b"),
                 {rotation_matrix(half), Vector3<double>::zero()});
  }
}

TEST(UrdfAxes, NormalizeWithAWarning) {
  const UrdfResult result =
      parse_urdf(robot_element(link_element("a") + link_element("b") +
                               joint_element("j", "continuous", "a", "b", "<axis xyz=\"0 3 0\"/>")),
                 "f");
  ASSERT_TRUE(result.model);
  EXPECT_EQ(problem_with(result, "has length 3 and is normalized"), "j");
}

TEST(UrdfLimits, ContinuousJointHasNoAngleLimit) {
  const RobotModel model = built(robot_element(
      link_element("a") + link_element("b") +
      joint_element("j", "continuous", "a", "b",
                    "<limit lower=\"-1\" upper=\"1\" effort=\"5\" velocity=\"6\"/>")));
  EXPECT_EQ(model.nq, 1);
  EXPECT_EQ(model.joints[0].lower, -kUnlimited);
  EXPECT_EQ(model.joints[0].upper, kUnlimited);
  EXPECT_EQ(model.joints[0].max_effort, 5);
}

TEST(UrdfLimits, KeepsZeroLimitsWithAWarning) {
  const UrdfResult result =
      parse_urdf(robot_element(link_element("a") + link_element("b") +
                               joint_element("j", "revolute", "a", "b",
                                             "<limit effort=\"0\" velocity=\"0\"/>")),
                 "f");
  ASSERT_TRUE(result.model);
  EXPECT_EQ(result.model->joints[0].max_effort, 0);
  EXPECT_EQ(problem_with(result, "effort limit is 0"), "j");
  EXPECT_EQ(problem_with(result, "velocity limit is 0"), "j");
  EXPECT_EQ(problem_with(result, "limits are both 0"), "j");
}

TEST(UrdfLimits, IgnoresZeroLimitsOfLockedJoints) {
  const UrdfResult result =
      parse_urdf(robot_element(link_element("a") + link_element("b") + link_element("c") +
                               joint_element("j", "revolute", "a", "b",
                                             "<limit effort=\"0\" velocity=\"0\"/>") +
                               joint_element("k", "continuous", "b", "c")),
                 "f", {.locked_joints = {{"j", 0}}});
  ASSERT_TRUE(result.model);
  EXPECT_TRUE(result.problems.empty()) << result.problems.front().message;
}

TEST(UrdfMerging, FixedLinkAddsInertiaAndKeepsFrames) {
  const std::string tail = joint_element("weld", "fixed", "b", "c", kOrigin) +
                           joint_element("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>");
  const RobotModel merged =
      built(robot_element(link_element("a") + link_element("b") + link_element("c") + tail));
  const RobotModel upper =
      built(robot_element(link_element("a") + link_element("b") + link_element("c", "") + tail));
  const RobotModel lower =
      built(robot_element(link_element("a") + link_element("b", "") + link_element("c") + tail));
  ASSERT_EQ(merged.joint_count(), 1);
  Inertia<double> sum = upper.joints[0].inertia;
  sum += lower.joints[0].inertia;
  expect_equal(merged.joints[0].inertia, sum);
  for (const char* name : {"a", "b", "c", "weld", "j"})
    EXPECT_TRUE(merged.find_frame(name)) << name;
  EXPECT_EQ(merged.frames.size(), 5u);
  expect_equal(simple_frame_placement(merged, {0.3}, "c"),
               simple_frame_placement(merged, {0.3}, "weld"));
}

TEST(UrdfLocking, EqualsTheFreeJointHeldAtTheValue) {
  for (const char* type : {"revolute", "prismatic"}) {
    const std::string xml = robot_element(
        link_element("a") + link_element("b") + link_element("c") +
        joint_element("i", "continuous", "a", "b", std::string(kOrigin) + "<axis xyz=\"1 0 0\"/>") +
        joint_element("j", type, "b", "c",
                      std::string(kOrigin) + "<axis xyz=\"0.6 0 0.8\"/>"
                                             "<limit lower=\"-2\" upper=\"2\" effort=\"1\" "
                                             "velocity=\"1\"/>"));
    const RobotModel open = built(xml);
    const RobotModel locked = built(xml, {.locked_joints = {{"j", 1.3}}});
    ASSERT_EQ(joint_names(locked), std::vector<std::string>{"i"});
    for (const char* name : {"c", "j"})
      expect_equal(simple_frame_placement(locked, {0.4}, name),
                   simple_frame_placement(open, {0.4, 1.3}, name));
    EXPECT_NEAR(simple_inertia_matrix(locked, {0.4})(0, 0),
                simple_inertia_matrix(open, {0.4, 1.3})(0, 0), 1e-14);
  }
}

TEST(UrdfPayload, EqualsAnotherBodyWeldedToTheLink) {
  const std::string tail = joint_element("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>");
  const std::string load =
      R"(<inertial><origin xyz="0.1 0.2 0.3"/><mass value="4"/>
         <inertia ixx="0.1" ixy="0" ixz="0.01" iyy="0.2" iyz="0" izz="0.25"/></inertial>)";
  const RobotModel welded =
      built(robot_element(link_element("a") + link_element("b") + link_element("load", load) +
                          tail + joint_element("weld", "fixed", "b", "load")));
  UrdfOptions options;
  options.payloads.push_back({.link = "b",
                              .mass = 4,
                              .com = {0.1, 0.2, 0.3},
                              .inertia = Symmetric3<double>{0.1, 0, 0.01, 0.2, 0, 0.25}});
  const RobotModel loaded =
      built(robot_element(link_element("a") + link_element("b") + tail), options);
  expect_equal(loaded.joints[0].inertia, welded.joints[0].inertia);
}

TEST(UrdfRotors, RegularizeAMasslessLink) {
  const std::string xml = robot_element(link_element("a") + link_element("b", "") +
                                        joint_element("j", "continuous", "a", "b"));
  EXPECT_FALSE(parse_urdf(xml, "f").model);
  EXPECT_EQ(built(xml, {.rotor_inertia = {{"j", 0.01}}}).joints[0].rotor_inertia, 0.01);
}

TEST(UrdfRegularity, AcceptsAMasslessBodyBetweenCrossedAxes) {
  const RobotModel model =
      built(robot_element(link_element("a") + link_element("b", "") + link_element("c") +
                          joint_element("j", "continuous", "a", "b", "<axis xyz=\"0 1 0\"/>") +
                          joint_element("k", "continuous", "b", "c", "<axis xyz=\"1 0 0\"/>")));
  EXPECT_EQ(model.nv, 2);
}

TEST(UrdfBase, FloatingPutsRootOnAFreeJoint) {
  const RobotModel model = built(robot_element(link_element("a") + link_element("b") +
                                               joint_element("j", "continuous", "a", "b")),
                                 {.base = UrdfOptions::Base::floating});
  EXPECT_EQ(joint_names(model), (std::vector<std::string>{"base", "j"}));
  EXPECT_EQ(model.nq, 8);
  EXPECT_EQ(model.nv, 7);
  EXPECT_EQ(model.neutral_configuration()[6], 1);
  const double s = std::sqrt(0.5);
  expect_equal(simple_frame_placement(model, {1, 2, 3, 0, 0, s, s, 0.2}, "a"),
               {{{0, -1, 0, 1, 0, 0, 0, 0, 1}}, {1, 2, 3}});
}

TEST(UrdfBase, DoesNotReuseNamesInTheFile) {
  const RobotModel model = built(robot_element(link_element("a") + link_element("b") +
                                               joint_element("base", "continuous", "a", "b")),
                                 {.base = UrdfOptions::Base::floating});
  EXPECT_EQ(joint_names(model), (std::vector<std::string>{"base_", "base"}));
}

TEST(UrdfBase, PlanarSlidesInPlaneAndTurnsAboutZ) {
  const RobotModel model =
      built(robot_element(link_element("a")), {.base = UrdfOptions::Base::planar});
  EXPECT_EQ(joint_names(model), (std::vector<std::string>{"base_x", "base_y", "base_yaw"}));
  expect_equal(simple_frame_placement(model, {1, 2, kPi / 2}, "a"),
               {{{0, -1, 0, 1, 0, 0, 0, 0, 1}}, {1, 2, 0}});
  EXPECT_NEAR(simple_inertia_matrix(model, {1, 2, 0.3})(0, 0), 2, 1e-14);
}

TEST(UrdfBase, PlanarJointMovesAcrossItsAxis) {
  const RobotModel model =
      built(robot_element(link_element("world", "") + link_element("a") +
                          joint_element("slide", "planar", "world", "a",
                                        "<origin xyz=\"0 0 1\"/><axis xyz=\"0 1 0\"/>")));
  EXPECT_EQ(joint_names(model), (std::vector<std::string>{"slide_x", "slide_y", "slide_yaw"}));
  EXPECT_TRUE(model.find_frame("slide"));
  const SE3<double> moved = simple_frame_placement(model, {0.3, -0.4, 0.5}, "a");
  EXPECT_NEAR(moved.p.y, 0, 1e-15);
  EXPECT_NEAR(std::hypot(moved.p.x, moved.p.z - 1), 0.5, 1e-15);
  EXPECT_NEAR(moved.R(1, 1), 1, 1e-15);
  expect_equal(simple_frame_placement(model, {0, 0, 0}, "a"),
               {Matrix3<double>::identity(), {0, 0, 1}}, 0);
}

TEST(UrdfBase, FloatingRootJointIsAFloatingBase) {
  const std::string xml =
      robot_element(link_element("world", "") + link_element("shelf", "") + link_element("a") +
                    joint_element("bolts", "fixed", "world", "shelf") +
                    joint_element("free", "floating", "shelf", "a", "<origin xyz=\"0 0 1\"/>"));
  for (const auto base : {UrdfOptions::Base::fixed, UrdfOptions::Base::floating}) {
    const UrdfResult result = parse_urdf(xml, "f", {.base = base});
    ASSERT_TRUE(result.model);
    EXPECT_EQ(joint_names(*result.model), std::vector<std::string>{"free"});
    EXPECT_EQ(result.model->joints[0].type, JointType::floating);
    EXPECT_TRUE(has_note(result, "relative to the world's origin"));
    expect_equal(simple_frame_placement(*result.model, result.model->neutral_configuration(), "a"),
                 SE3<double>::identity(), 0);
  }
}

TEST(UrdfBase, FixedBaseStandsAtItsPlacement) {
  UrdfOptions options;
  options.placement = SE3<double>{{{0, -1, 0, 1, 0, 0, 0, 0, 1}}, {1, 2, 3}};
  const std::string xml = robot_element(link_element("a") + link_element("b") +
                                        joint_element("j", "continuous", "a", "b", kOrigin));
  const SE3<double> moved = simple_frame_placement(built(xml, options), {0.4}, "b");
  expect_equal(moved, *options.placement * simple_frame_placement(built(xml), {0.4}, "b"));
}

TEST(UrdfBase, WarnsWithoutMovingJoints) {
  const UrdfResult result = parse_urdf(robot_element(link_element("a")), "f");
  ASSERT_TRUE(result.model);
  EXPECT_EQ(problem_with(result, "no joint of the robot moves"), "");
}

std::string three_joints(const std::string& mimic_j, const std::string& mimic_k) {
  return robot_element(link_element("a") + link_element("b") + link_element("c") +
                       link_element("d") + joint_element("i", "continuous", "a", "b") +
                       joint_element("j", "continuous", "b", "c", mimic_j) +
                       joint_element("k", "continuous", "c", "d", mimic_k));
}

TEST(UrdfMimic, IsANoteUnlessEnforced) {
  const UrdfResult result = parse_urdf(three_joints("<mimic joint=\"i\"/>", ""), "f");
  ASSERT_TRUE(result.model);
  EXPECT_TRUE(result.model->mimics.empty());
  EXPECT_TRUE(has_note(result, "mimic joints are independent unless the problem enforces them: j"));
}

TEST(UrdfMimic, ResolvesChainsToTheLeader) {
  const RobotModel model =
      built(three_joints("<mimic joint=\"i\" multiplier=\"2\" offset=\"0.5\"/>",
                         "<mimic joint=\"j\" multiplier=\"-3\" offset=\"1\"/>"),
            {.enforce_mimic = true});
  ASSERT_EQ(model.mimics.size(), 2u);
  EXPECT_EQ(model.mimics[0].joint, 1);
  EXPECT_EQ(model.mimics[0].leader, 0);
  EXPECT_EQ(model.mimics[0].multiplier, 2);
  EXPECT_EQ(model.mimics[0].offset, 0.5);
  EXPECT_EQ(model.mimics[1].joint, 2);
  EXPECT_EQ(model.mimics[1].leader, 0);
  EXPECT_EQ(model.mimics[1].multiplier, -6);
  EXPECT_EQ(model.mimics[1].offset, -0.5);
}

TEST(UrdfMimic, LockedFollowerDoesNotFollow) {
  UrdfOptions options;
  options.enforce_mimic = true;
  options.locked_joints["j"] = 0.2;
  EXPECT_TRUE(built(three_joints("<mimic joint=\"i\"/>", ""), options).mimics.empty());
}

TEST(UrdfMimic, LockedLeaderLocksItsFollowers) {
  const std::string follower = "<mimic joint=\"i\" multiplier=\"2\" offset=\"0.5\"/>",
                    next = "<mimic joint=\"j\" multiplier=\"-3\" offset=\"1\"/>";
  UrdfOptions all, none;
  all.locked_joints = {{"i", 0.2}};
  all.enforce_mimic = true;
  none.locked_joints = {{"i", 0.2}, {"j", 0.9}, {"k", -1.7}};
  const RobotModel model = built(three_joints(follower, next), all);
  EXPECT_EQ(model.joint_count(), 0);
  expect_equal(simple_frame_placement(model, {}, "d"),
               simple_frame_placement(built(three_joints("", ""), none), {}, "d"));
  // Explicitly locked followers keep their values; without `enforce`, nothing follows.
  all.locked_joints["j"] = 0;
  none.locked_joints = {{"i", 0.2}, {"j", 0}, {"k", 1}};
  expect_equal(simple_frame_placement(built(three_joints(follower, next), all), {}, "d"),
               simple_frame_placement(built(three_joints("", ""), none), {}, "d"));
  all.enforce_mimic = false;
  EXPECT_EQ(built(three_joints(follower, next), all).joint_count(), 1);
}

TEST(UrdfPatterns, LockMatchingJointsByBestPattern) {
  const std::string xml = three_joints("", "");  // i, j, k
  const auto placed = [&](const std::map<std::string, double>& locked) {
    UrdfOptions options;
    options.locked_joints = locked;
    const RobotModel model = built(xml, options);
    EXPECT_EQ(model.joint_count(), 0);
    return simple_frame_placement(model, {}, "d");
  };
  const auto expected = placed({{"i", 0.2}, {"j", -0.3}, {"k", -0.3}});
  expect_equal(placed({{"*", -0.3}, {"i", 0.2}}), expected);
  expect_equal(placed({{"*", -0.3}, {"i*", 0.2}}), expected);
  expect_equal(placed({{"*k", -0.3}, {"*", 0.2}, {"j", -0.3}}), expected);
  UrdfOptions one;
  one.locked_joints = {{"k*", 0.1}};
  EXPECT_EQ(joint_names(built(xml, one)), (std::vector<std::string>{"i", "j"}));
}

TEST(UrdfPatterns, LeaveFollowersToTheirLeaders) {
  const std::string xml = three_joints("<mimic joint=\"i\" multiplier=\"2\" offset=\"0.5\"/>", "");
  UrdfOptions options, by_name;
  options.enforce_mimic = by_name.enforce_mimic = true;
  options.locked_joints = {{"*", 0.2}};
  by_name.locked_joints = {{"i", 0.2}, {"j", 0.9}, {"k", 0.2}};
  expect_equal(simple_frame_placement(built(xml, options), {}, "d"),
               simple_frame_placement(built(xml, by_name), {}, "d"));
}

TEST(UrdfPatterns, GiveRotorsToUnlockedJoints) {
  const std::string xml = three_joints("", "");
  UrdfOptions options, by_name;
  options.locked_joints = by_name.locked_joints = {{"j", 0.1}};
  options.rotor_inertia = {{"*", 0.3}, {"k", 0.7}};
  by_name.rotor_inertia = {{"i", 0.3}, {"k", 0.7}};
  const UrdfResult result = parse_urdf(xml, "robot.urdf", options);
  ASSERT_TRUE(result.model);
  for (const UrdfProblem& problem : result.problems)
    EXPECT_EQ(problem.message.find("rotor"), std::string::npos) << problem.message;
  EXPECT_EQ(simple_inertia_matrix(*result.model, {0.4, 0.3}),
            simple_inertia_matrix(built(xml, by_name), {0.4, 0.3}));
}

TEST(UrdfNotes, ListOmissionsOfTheModel) {
  const UrdfResult result =
      parse_urdf(robot_element(link_element("a") + link_element("b") +
                               joint_element("j", "continuous", "a", "b",
                                             "<dynamics damping=\"0.1\" friction=\"0.2\"/>")),
                 "f");
  ASSERT_TRUE(result.model);
  EXPECT_EQ(result.model->joints[0].damping, 0.1);
  EXPECT_EQ(result.model->joints[0].friction, 0.2);
  EXPECT_TRUE(has_note(result, "joint damping is ignored unless the problem asks for it: j"));
  EXPECT_TRUE(has_note(result, "joint friction is ignored"));
  EXPECT_TRUE(has_note(result, "2 kg rigid with the world have no effect"));
}

TEST(UrdfWarnings, NameMisspeltElementsAndAttributes) {
  const UrdfResult result = parse_urdf(
      robot_element(link_element("a") + link_element("b", std::string(kBody) + "<inertail/>") +
                    joint_element("j", "continuous", "a", "b",
                                  "<axiss/><limit efort=\"1\" effort=\"1\" "
                                  "velocity=\"1\"/>")),
      "f");
  ASSERT_TRUE(result.model);
  EXPECT_EQ(problem_with(result, "<inertail> is not a URDF element"), "b");
  EXPECT_EQ(problem_with(result, "<axiss> is not a URDF element"), "j");
  EXPECT_EQ(problem_with(result, "has an attribute efort, which is ignored"), "j");
}

TEST(UrdfWarnings, IncludeImpossibleInertiaOfMergedParts) {
  const std::string placeholder =
      R"(<inertial><mass value="1e-6"/><inertia ixx="1e-6" ixy="1e-6" ixz="1e-6" iyy="1e-6"
         iyz="1e-6" izz="1e-6"/></inertial>)";
  const UrdfResult result = parse_urdf(
      robot_element(link_element("a") + link_element("b") + link_element("foot", placeholder) +
                    joint_element("j", "continuous", "a", "b") +
                    joint_element("weld", "fixed", "b", "foot")),
      "f");
  EXPECT_TRUE(result.model);
  EXPECT_EQ(problem_with(result, "its inertia is not physically valid"), "foot");
}

TEST(Combine, NumbersTreesOneAfterTheOther) {
  const std::string xml = three_joints("<mimic joint=\"i\"/>", "");
  RobotModel left = built(xml, {.enforce_mimic = true, .prefix = "left/"});
  RobotModel right =
      built(xml, {.base = UrdfOptions::Base::floating, .enforce_mimic = true, .prefix = "right/"});
  const RobotModel both = combine({left, right});
  EXPECT_EQ(joint_names(both), (std::vector<std::string>{"left/i", "left/j", "left/k", "right/base",
                                                         "right/i", "right/j", "right/k"}));
  EXPECT_EQ(both.nv, left.nv + right.nv);
  EXPECT_EQ(both.joints[4].parent, 3);
  ASSERT_EQ(both.mimics.size(), 2u);
  EXPECT_EQ(both.mimics[1].joint - 4, both.mimics[0].joint);
  EXPECT_EQ(both.mimics[0].leader, 0);
  EXPECT_EQ(both.mimics[1].leader, 4);
  EXPECT_EQ(both.root[2], -1);
  EXPECT_EQ(both.root[6], 3);
  EXPECT_EQ(both.frames[*both.find_frame("right/b")].joint, 4);
}

TEST(Combine, WrenchesStayOnTheirFrames) {
  RobotModel left = built(three_joints("", ""), {.prefix = "left/"});
  RobotModel right = built(three_joints("", ""), {.prefix = "right/"});
  right.wrenches = {{*right.find_frame("right/c"), {{1, 2, 3}, {4, 5, 6}}}};
  const RobotModel both = combine({left, right});
  ASSERT_EQ(both.wrenches.size(), 1u);
  EXPECT_EQ(both.wrenches[0].frame, *both.find_frame("right/c"));
  EXPECT_EQ(both.wrenches[0].wrench.angular.z, 6);
  right.gravity.x = 1;
  EXPECT_THROW(combine({left, right}), std::logic_error);
  EXPECT_THROW(combine({}), std::logic_error);
}

TEST(Combine, ConflictingNamesGetTheRobotName) {
  const RobotModel one = built(three_joints("", ""));
  const RobotModel all = combine({one, one, one});
  EXPECT_TRUE(all.find_joint("i"));
  EXPECT_TRUE(all.find_joint("r/i"));
  EXPECT_TRUE(all.find_joint("r_2/i"));
  EXPECT_TRUE(all.find_frame("r_2/d"));
}

}  // namespace
}  // namespace conddp
