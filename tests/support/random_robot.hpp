#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "robot/dynamics.hpp"
#include "support/random_numbers.hpp"

namespace conddp {

struct RandomRobotOptions {
  int joints = 8;  ///< with one degree of freedom
  bool floating = false;
  double branching = 0.3;  ///< probability that a joint attaches to an earlier joint
  double prismatic = 0.25;
  bool rotors = true;
  int wrenches = 3;
};

/// A tree with joint placements and inertias in all directions, a frame on every body, more frames
/// on some bodies, and one on the world.
RobotModel random_robot(std::uint64_t seed, const RandomRobotOptions& options);

/// A floating torso with legs of six joints, arms of eight, and a waist and a head of two joints:
/// 38 degrees of freedom.
RobotModel humanoid_like_robot(std::uint64_t seed);

/// The robot with loads on its first and last body and another in between, two of them sharing one
/// parameter. For parameters from −3, all inertias are physically valid.
RobotModel loaded_robot(RobotModel model, std::uint64_t seed);

struct TestModel {
  std::string name;
  RobotModel model;
};

/// Robots for kernel property tests: chains and trees, fixed and floating, with and without rotors,
/// wrenches, and loads, and two trees in one model.
const std::vector<TestModel>& random_robots();

struct RobotState {
  std::vector<double> q, v, a, tau;
};

/// Any base pose, angles in ±3 rad, velocities in ±2, accelerations in ±5, forces in ±20.
/// Parameters, in ±3, are at rest.
RobotState random_state(const RobotModel& model, RandomNumbers& random);

/// Accelerations under generalized forces: M a = tau − bias. Writes M, L, bias, and acceleration. A
/// null tau means zero forces.
template <class S>
void forward_dynamics(const RobotModel& model, const S* q, const S* v, const S* tau,
                      RobotData<S>& data) {
  update_placements(model, q, data);
  update_velocities(model, v, data);
  mass_matrix(model, data);
  factorize_mass_matrix(model, data);
  bias_forces(model, v, data);
  for (int i = 0; i < model.nv; ++i)
    data.acceleration[i] = tau == nullptr ? -data.bias[i] : tau[i] - data.bias[i];
  solve_mass_matrix(model, data, data.acceleration.data());
}

}  // namespace conddp
