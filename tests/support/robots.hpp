#pragma once

#include <cstdlib>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "robot/urdf/urdf.hpp"
#include "support/source_tree.hpp"

namespace conddp {

/// A robot that tests load, with its intended base.
struct TestRobot {
  std::string name;  ///< stem of the file
  std::filesystem::path urdf;
  UrdfOptions::Base base = UrdfOptions::Base::fixed;
};

/// The robots of problems/robots.
inline std::vector<TestRobot> our_robots() {
  using Base = UrdfOptions::Base;
  const std::filesystem::path folder = source_tree() / "problems/robots";
  return {{"cartpole", folder / "cartpole.urdf", Base::fixed},
          {"double_pendulum", folder / "double_pendulum.urdf", Base::fixed},
          {"arm7", folder / "arm7.urdf", Base::fixed},
          {"quadruped", folder / "quadruped.urdf", Base::floating},
          {"free_body", folder / "free_body.urdf", Base::floating},
          {"quadrotor", folder / "quadrotor.urdf", Base::floating}};
}

/// Five robots with every kind of base, for derivative checks by name.
inline std::vector<TestRobot> five_robots() {
  using Base = UrdfOptions::Base;
  const std::filesystem::path folder = source_tree() / "problems/robots";
  return {{"quadruped", folder / "quadruped.urdf", Base::floating},
          {"biped", folder / "biped.urdf", Base::floating},
          {"hopper", folder / "hopper.urdf", Base::planar},
          {"arm7", folder / "arm7.urdf", Base::fixed},
          {"double_pendulum", folder / "double_pendulum.urdf", Base::fixed}};
}

inline std::shared_ptr<const RobotModel> load(const TestRobot& robot) {
  return std::make_shared<RobotModel>(*load_urdf(robot.urdf, {.base = robot.base}).model);
}

/// Folder of robots from outside the product: CONDDP_ROBOTS_DIR, or else shared/robots beside the
/// sources. It may not exist.
inline std::filesystem::path foreign_robot_folder() {
  if (const char* folder = std::getenv("CONDDP_ROBOTS_DIR")) return folder;
  return source_tree().parent_path() / "shared/robots";
}

inline constexpr const char* kNoForeignRobots =
    "no folder with further robots: set CONDDP_ROBOTS_DIR to one";

/// Robots of that folder that tests know; empty if it is absent. Names begin with "foreign_" if one
/// of ours has the same name.
inline std::vector<TestRobot> foreign_robots() {
  using Base = UrdfOptions::Base;
  const std::filesystem::path folder = foreign_robot_folder();
  std::vector<TestRobot> robots;
  const auto add = [&](const char* name, const char* file, Base base) {
    if (std::filesystem::exists(folder / file)) robots.push_back({name, folder / file, base});
  };
  add("hyq", "hyq.urdf", Base::floating);
  add("anymal_b", "anymal_b.urdf", Base::floating);
  add("solo12", "solo12.urdf", Base::floating);
  add("bolt", "bolt.urdf", Base::floating);
  add("talos_reduced", "talos_reduced.urdf", Base::floating);
  add("iris_quadrotor", "iris_quadrotor.urdf", Base::floating);
  add("panda", "panda.urdf", Base::fixed);
  add("kinova", "kinova.urdf", Base::fixed);
  add("ur5", "ur5.urdf", Base::fixed);
  add("ur10", "ur10.urdf", Base::fixed);
  add("foreign_double_pendulum", "double_pendulum.urdf", Base::fixed);
  add("double_pendulum_continuous", "double_pendulum_continuous.urdf", Base::fixed);
  return robots;
}

/// Pinocchio's values for the robot at random states (scripts/peers/robot_fixtures.py); the file
/// need not exist.
inline std::filesystem::path fixture_path(const TestRobot& robot) {
  return source_tree() / "tests/robot/data" / (robot.name + ".json");
}

}  // namespace conddp
