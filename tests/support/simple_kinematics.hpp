#pragma once

#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "robot/model.hpp"

namespace conddp {

/// Kinematics and inertia of a model in the plainest form, to check loaded models independently of
/// the kernels.
inline std::vector<SE3<double>> simple_joint_placements(const RobotModel& model,
                                                        const std::vector<double>& q) {
  std::vector<SE3<double>> world;
  for (const Joint& joint : model.joints) {
    const double* at = &q[joint.q];
    SE3<double> motion = SE3<double>::identity();
    if (joint.type == JointType::floating) {
      motion = {rotation_matrix(Quaternion<double>{at[3], at[4], at[5], at[6]}),
                {at[0], at[1], at[2]}};
    } else if (joint.type == JointType::prismatic) {
      motion.p = {0, 0, at[0]};
    } else {
      const double c = std::cos(at[0]), s = std::sin(at[0]);
      motion.R = {{c, -s, 0, s, c, 0, 0, 0, 1}};
    }
    const SE3<double> parent = joint.parent < 0 ? SE3<double>::identity() : world[joint.parent];
    world.push_back(parent * joint.placement * motion);
  }
  return world;
}

inline SE3<double> simple_frame_placement(const RobotModel& model, const std::vector<double>& q,
                                          const std::string& name) {
  const auto index = model.find_frame(name);
  if (!index) throw std::runtime_error("no frame " + name);
  const Frame& frame = model.frames[*index];
  if (frame.joint < 0) return frame.placement;
  return simple_joint_placements(model, q)[frame.joint] * frame.placement;
}

inline Vector3<double> simple_com(const RobotModel& model, const std::vector<double>& q) {
  const auto world = simple_joint_placements(model, q);
  Vector3<double> moment = Vector3<double>::zero();
  for (int i = 0; i < model.joint_count(); ++i)
    moment += act(world[i], model.joints[i].inertia).moment;
  return (1 / model.total_mass()) * moment;
}

/// Σ Jᵀ I J over the bodies, in world axes at the world origin.
inline Eigen::MatrixXd simple_inertia_matrix(const RobotModel& model,
                                             const std::vector<double>& q) {
  const auto world = simple_joint_placements(model, q);
  std::vector<Motion<double>> columns;
  for (int i = 0; i < model.joint_count(); ++i) {
    const Joint& joint = model.joints[i];
    for (int k = 0; k < joint.nv(); ++k) {
      Motion<double> axis = Motion<double>::zero();
      axis[joint.type == JointType::floating ? k : joint.type == JointType::prismatic ? 2 : 5] = 1;
      columns.push_back(act(world[i], axis));
    }
  }
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(model.nv, model.nv);
  for (int body = 0; body < model.joint_count(); ++body) {
    const Inertia<double> inertia = act(world[body], model.joints[body].inertia);
    std::vector<int> path;
    for (int dof = model.joints[body].v + model.joints[body].nv() - 1; dof >= 0;
         dof = model.parent_dof[dof])
      path.push_back(dof);
    for (const int i : path)
      for (const int j : path) m(i, j) += dot(columns[i], inertia * columns[j]);
  }
  for (const Joint& joint : model.joints) m(joint.v, joint.v) += joint.rotor_inertia;
  return m;
}

}  // namespace conddp
