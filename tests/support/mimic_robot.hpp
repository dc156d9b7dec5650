#pragma once

#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "robot/model.hpp"
#include "support/random_robot.hpp"

namespace conddp {

/// One-DoF joints of a model.
inline std::vector<int> simple_joints(const RobotModel& model) {
  std::vector<int> joints;
  for (int i = 0; i < model.joint_count(); ++i)
    if (model.joints[i].type != JointType::floating) joints.push_back(i);
  return joints;
}

/// Robots with mimic joints: leaders before and after their followers, several followers of one
/// leader, sliders following hinges, in one tree, across branches, and across trees. Every joint
/// has its own damping and friction.
inline std::vector<TestModel> mimic_robots() {
  std::vector<TestModel> robots;
  const auto add = [&](const char* name, RobotModel model) {
    const std::vector<int> joints = simple_joints(model);
    const int n = static_cast<int>(joints.size());
    model.mimics = {{joints[0], joints[n / 2], -0.7, 0.3},
                    {joints[n / 2 + 1], joints[n / 2], 1.6, -0.2},
                    {joints[n - 1], joints[1], 0.5, 0.1}};
    for (int i = 0; i < n; ++i) {
      model.joints[joints[i]].damping = 0.1 + 0.05 * i;
      model.joints[joints[i]].friction = 0.3 + 0.02 * i;
    }
    robots.push_back({name, std::move(model)});
  };
  add("chain", random_robot(51, {.joints = 6, .branching = 0, .wrenches = 1}));
  add("tree", random_robot(52, {.joints = 8, .branching = 0.5, .wrenches = 2}));
  add("sliders", random_robot(53, {.joints = 5, .prismatic = 0.6, .wrenches = 1}));
  add("floating", random_robot(54, {.joints = 7, .floating = true, .wrenches = 2}));
  add("two_trees", combine({random_robot(55, {.joints = 4, .floating = true, .wrenches = 1}),
                            random_robot(56, {.joints = 3, .wrenches = 1})}));
  return robots;
}

/// Mimic constraints C v = 0 on full velocities: one row per mimic joint.
inline Eigen::MatrixXd mimic_constraints(const RobotModel& model) {
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(static_cast<int>(model.mimics.size()), model.nv);
  for (std::size_t i = 0; i < model.mimics.size(); ++i) {
    const Mimic& mimic = model.mimics[i];
    C(static_cast<int>(i), model.joints[mimic.joint].v) = 1;
    C(static_cast<int>(i), model.joints[mimic.leader].v) = -mimic.multiplier;
  }
  return C;
}

/// A random state of all joints that satisfies the constraints.
inline RobotState random_mimic_state(const RobotModel& model, RandomNumbers& random) {
  RobotState state = random_state(model, random);
  for (const Mimic& mimic : model.mimics) {
    const Joint &joint = model.joints[mimic.joint], &leader = model.joints[mimic.leader];
    state.q[joint.q] = mimic.multiplier * state.q[leader.q] + mimic.offset;
    state.v[joint.v] = mimic.multiplier * state.v[leader.v];
  }
  return state;
}

}  // namespace conddp
