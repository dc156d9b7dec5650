#pragma once

#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include "analysis/contact/stepping_equations.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/source_tree.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A plant of a robot of problems/robots with controls on the named joints.
inline ContactPlant contact_plant(const std::string& name, const std::vector<std::string>& actuated,
                                  const Vector3<double>& gravity = {0, 0, -9.81}) {
  const auto file = source_tree() / "problems/robots" / (name + ".urdf");
  ContactPlant plant;
  plant.robot = std::make_shared<RobotModel>(*load_urdf(file, {.gravity = gravity}).model);
  plant.B = Actuation::joints(*plant.robot, actuated).B;
  plant.contacts.plane = Vector3<double>{0, 1, 0};  // its tangent on the ground is +x
  return plant;
}

inline int velocity_index(const ContactPlant& plant, const std::string& joint) {
  return plant.robot->joints[plant.robot->find_joint(joint).value()].v;
}

/// A rigid, frictional point or ball on a robot frame above ground.
inline ContactCandidate on_ground(const ContactPlant& plant, const std::string& frame,
                                  double friction, double radius = 0) {
  ContactCandidate candidate;
  candidate.name = frame;
  candidate.sphere = {.frame = plant.robot->find_frame(frame).value(), .radius = radius};
  candidate.against = ContactHalfSpace{};
  candidate.friction = friction;
  return candidate;
}

/// The 1 kg block with all corners above ground; gravity is rotated by the slope angle, so that it
/// pulls towards +x.
inline ContactPlant block_on_slope(double friction, double angle = 0) {
  ContactPlant plant =
      contact_plant("block", {"base_x"}, {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)});
  for (const char* corner : {"corner_1", "corner_2", "corner_3", "corner_4"})
    plant.contacts.candidates.push_back(on_ground(plant, corner, friction));
  return plant;
}

/// The 1 kg crate, a floating cube of 0.2 m, with all corners above ground.
inline ContactPlant crate(double friction, FrictionModel model = FrictionModel::polyhedron) {
  const auto file = source_tree() / "problems/robots/crate.urdf";
  ContactPlant plant;
  plant.robot =
      std::make_shared<RobotModel>(*load_urdf(file, {.base = UrdfOptions::Base::floating}).model);
  plant.contacts.friction = model;
  for (int i = 1; i <= 8; ++i)
    plant.contacts.candidates.push_back(on_ground(plant, "corner_" + std::to_string(i), friction));
  return plant;
}

/// The crate at rest with its center at height z, rotated by `pitch` about y.
inline StepStart crate_start(double z, double pitch, double h) {
  StepStart start{Eigen::VectorXd::Zero(7), Eigen::VectorXd::Zero(6), Eigen::VectorXd::Zero(6), h};
  start.q[2] = z;
  start.q[4] = std::sin(pitch / 2);
  start.q[6] = std::cos(pitch / 2);
  return start;
}

/// Start of a step at rest in the zero configuration.
inline StepStart at_rest(const ContactPlant& plant, double h) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(plant.nv());
  return {zero, zero, zero, h};
}

}  // namespace conddp
