#include <cmath>
#include <numbers>
#include <set>

#include <gtest/gtest.h>

#include "robot/frames.hpp"
#include "robot/kinematics.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// A robot of the contact-implicit problems; all are planar and fixed.
struct PlanarRobot {
  const char* name;
  int nv;
  double mass;  ///< kg, of all moving parts
};

constexpr PlanarRobot kRobots[] = {
    {"block", 3, 1},
    {"acrobot", 2, 2},
    {"cartpole_walls", 2, 1.1},
    {"footed_hopper", 5, 37. / 3},
    {"raibert_hopper", 4, 1.1},
    {"finger_spinner", 3, 3},
    {"push_box", 5, 1.1},
    {"push_slider", 5, 0.12},
    {"planar_biped", 7, 24},
    {"planar_quadruped", 11, 11.6},
    {"ball_rim", 3, 0.5},
    {"box_two_fingers", 7, 0.7},
};

UrdfResult read(const std::string& name) {
  return load_urdf(source_tree() / "problems/robots" / (name + ".urdf"));
}

/// Frame positions at given joint positions, with all other joints at zero.
class Posture {
 public:
  Posture(const char* name, const std::vector<std::pair<const char*, double>>& positions)
      : robot_(*read(name).model), data_(robot_) {
    std::vector<double> q(robot_.nq, 0.0);
    for (const auto& [joint, value] : positions)
      q[robot_.joints[robot_.find_joint(joint).value()].q] = value;
    update_placements(robot_, q.data(), data_);
  }

  Vector3<double> operator()(const char* frame) const {
    return frame_placement(robot_, data_, robot_.find_frame(frame).value()).p;
  }

 private:
  RobotModel robot_;
  RobotData<double> data_;
};

void expect_near(const Vector3<double>& point, double x, double y, double z) {
  EXPECT_NEAR(point.x, x, 1e-9);
  EXPECT_NEAR(point.y, y, 1e-9);
  EXPECT_NEAR(point.z, z, 1e-9);
}

class ContactRobots : public testing::TestWithParam<PlanarRobot> {};

TEST_P(ContactRobots, LoadsWithoutFindings) {
  const UrdfResult result = read(GetParam().name);
  for (const UrdfProblem& problem : result.problems) ADD_FAILURE() << problem.message;
  ASSERT_TRUE(result.model);
  EXPECT_EQ(result.model->nv, GetParam().nv);
  EXPECT_EQ(result.model->nq, GetParam().nv);
  EXPECT_NEAR(result.model->total_mass(), GetParam().mass, 1e-9);
}

TEST_P(ContactRobots, StaysInItsPlane) {
  const RobotModel robot = *read(GetParam().name).model;
  RobotData<double> data(robot);
  std::vector<double> q(robot.nq);
  for (int i = 0; i < robot.nq; ++i) q[i] = 0.3 + 0.2 * std::sin(3.1 * i);
  const std::string_view name = GetParam().name;
  const bool from_above = name.starts_with("push") || name.starts_with("box");
  const auto off_plane = [&](const Vector3<double>& p) { return from_above ? p.z : p.y; };
  std::vector<double> at_zero;
  update_placements(robot, robot.neutral_configuration().data(), data);
  for (std::size_t f = 0; f < robot.frames.size(); ++f)
    at_zero.push_back(off_plane(frame_placement(robot, data, static_cast<int>(f)).p));
  update_placements(robot, q.data(), data);
  for (std::size_t f = 0; f < robot.frames.size(); ++f)
    EXPECT_NEAR(off_plane(frame_placement(robot, data, static_cast<int>(f)).p), at_zero[f], 1e-12)
        << robot.frames[f].name;
}

INSTANTIATE_TEST_SUITE_P(Robots, ContactRobots, testing::ValuesIn(kRobots),
                         [](const auto& chosen) { return std::string(chosen.param.name); });

TEST(ContactRobotPostures, MatchTheFiles) {
  const double upright = std::numbers::pi;
  expect_near(Posture("acrobot", {{"shoulder", upright}})("tip"), 0, 0, 2);
  expect_near(Posture("cartpole_walls", {{"slider", 0.3}, {"hinge", upright / 2}})("tip"), 1.1, 0,
              0);

  const Posture block("block", {{"base_z", 0.5}});
  expect_near(block("corner_1"), -0.5, 0, 0);
  expect_near(block("corner_2"), 0.5, 0, 0);
  expect_near(block("corner_3"), 0.5, 0, 1);
  expect_near(block("corner_4"), -0.5, 0, 1);
  EXPECT_LT(Posture("block", {{"base_pitch", 0.1}})("corner_2").z, -0.5);

  const Posture puck("puck", {{"base_y", 1}, {"base_z", 0.02}, {"base_yaw", std::numbers::pi}});
  expect_near(puck("foot_1"), -0.08, 1, 0);
  const Posture tilted("puck", {{"base_z", 0.02}, {"base_roll", 0.1}});
  EXPECT_GT(tilted("foot_2").z, 0);
  EXPECT_LT(tilted("foot_3").z, 0);

  const double a = std::acos(0.75);
  const Posture hopper(
      "footed_hopper",
      {{"base_z", 1.5}, {"hip", a}, {"knee", -2 * a}, {"ankle", std::numbers::pi / 2 + a}});
  expect_near(hopper("heel"), 0, 0, 0);
  expect_near(hopper("toe"), 0.333333333333, 0, 0);

  const Posture raibert("raibert_hopper", {{"base_z", 0.55}, {"leg", 0.5}, {"base_pitch", 0.2}});
  expect_near(raibert("foot"), 0.5 * std::sin(0.2), 0, 0.55 - 0.5 * std::cos(0.2));

  const Posture finger("finger_spinner", {{"shoulder", 0.3}, {"elbow", 1.5}});
  expect_near(finger("tip"), std::cos(0.3) + std::cos(1.8), 0, std::sin(0.3) + std::sin(1.8));
  expect_near(finger("hub"), 1.5, 0, 1);

  const Posture biped("planar_biped", {{"left_hip", -0.3}, {"left_knee", 0.6}});
  expect_near(biped("left_foot"), 0, 0, -0.8 * std::cos(0.3));
  expect_near(biped("right_foot"), 0, 0, -0.8);

  const Posture solo("solo12", {{"FL_HFE", 0.8}, {"FL_KFE", -1.6}});
  expect_near(solo("fl_foot"), 0.1946, 0.14695, -0.32 * std::cos(0.8));

  const Posture quadruped("planar_quadruped", {{"RH_hip", 0.7}, {"RH_knee", -1.4}});
  expect_near(quadruped("RH_foot"), -0.2, 0, -0.4 * std::cos(0.7));
}

}  // namespace
}  // namespace conddp
