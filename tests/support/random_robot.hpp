#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "robot/model.hpp"
#include "support/random_numbers.hpp"

namespace conddp {

struct RandomRobotOptions {
  int joints = 8;  ///< with one degree of freedom
  bool floating = false;
  double branching = 0.3;  ///< probability that a joint hangs on another one than the last
  double prismatic = 0.25;
  bool rotors = true;
  int wrenches = 3;
};

/// A tree with joint placements and inertias of every direction, a frame on every body, some more
/// on some bodies, and one on the world.
RobotModel random_robot(std::uint64_t seed, const RandomRobotOptions& options);

/// A floating torso with legs of six, arms of eight, and a waist and a head of two joints: 38
/// degrees of freedom.
RobotModel humanoid_like_robot(std::uint64_t seed);

/// The same robot with loads on its first and last body and another one in between, two of them of
/// one parameter. At parameters from −3 all inertias are those of bodies.
RobotModel loaded_robot(RobotModel model, std::uint64_t seed);

struct TestModel {
  std::string name;
  RobotModel model;
};

/// Robots on which properties of the kernels are tested: chains and trees, bolted down and
/// floating, with and without rotors, wrenches and loads, two trees in one model.
const std::vector<TestModel>& random_robots();

struct RobotState {
  std::vector<double> q, v, a, tau;
};

/// Any pose of the base, angles in ±3 rad, velocities in ±2, accelerations in ±5, forces in ±20.
/// Parameters in ±3 rest.
RobotState random_state(const RobotModel& model, RandomNumbers& random);

}  // namespace conddp
