#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "analysis/stepping_equations.hpp"
#include "robot/urdf.hpp"
#include "systems/multibody.hpp"

namespace conddp {

/// A plant of a robot of problems/robots with controls on the named joints.
inline ContactPlant contact_plant(const std::string& name, const std::vector<std::string>& actuated,
                                  const Vector3<double>& gravity = {0, 0, -9.81}) {
  const auto file = std::filesystem::path(CONDDP_SOURCE_DIR) / "problems/robots" / (name + ".urdf");
  ContactPlant plant;
  plant.robot = std::make_shared<RobotModel>(*load_urdf(file, {.gravity = gravity}).model);
  plant.B = Actuation::joints(*plant.robot, actuated).B;
  plant.contacts.plane = Vector3<double>{0, 1, 0};  // its tangent to the ground is +x
  return plant;
}

inline int velocity_index(const ContactPlant& plant, const std::string& joint) {
  return plant.robot->joints[plant.robot->find_joint(joint).value()].v;
}

/// A point or ball on a frame of the robot above ground, rigid and with friction.
inline ContactCandidate on_ground(const ContactPlant& plant, const std::string& frame,
                                  double friction, double radius = 0) {
  ContactCandidate candidate;
  candidate.name = frame;
  candidate.sphere = {.frame = plant.robot->find_frame(frame).value(), .radius = radius};
  candidate.against = ContactHalfSpace{};
  candidate.friction = friction;
  return candidate;
}

/// The block of 1 kg with all its corners above ground; gravity is turned by the slope's angle, so
/// that it pulls towards +x.
inline ContactPlant block_on_slope(double friction, double angle = 0) {
  ContactPlant plant =
      contact_plant("block", {"base_x"}, {9.81 * std::sin(angle), 0, -9.81 * std::cos(angle)});
  for (const char* corner : {"corner_1", "corner_2", "corner_3", "corner_4"})
    plant.contacts.candidates.push_back(on_ground(plant, corner, friction));
  return plant;
}

/// The start of a step at rest in the zero configuration.
inline StepStart at_rest(const ContactPlant& plant, double h) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(plant.nv());
  return {zero, zero, zero, h};
}

}  // namespace conddp
