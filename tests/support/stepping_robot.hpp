#pragma once

#include <memory>

#include "support/random_robot.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// A random robot with every contact-implicit feature: candidates with and without friction, rigid
/// and soft, on the world and on its own bodies, stops, and dry friction.
inline std::shared_ptr<const SteppingSystem> stepping_robot(
    bool planar, SteppingScheme scheme = SteppingScheme::backward_euler,
    FrictionModel friction = FrictionModel::polyhedron, bool floating = false) {
  const auto robot = std::make_shared<RobotModel>(
      random_robot(7, {.joints = 5, .floating = floating, .branching = 0.6}));
  int tip = 0, other = 0;
  for (int i = 0; i < static_cast<int>(robot->frames.size()); ++i) {
    if (robot->frames[i].joint == robot->joint_count() - 1) tip = i;
    if (robot->frames[i].joint == robot->joint_count() / 2) other = i;
  }
  const ContactSphere sphere{tip, {0.1, -0.2, 0.3}, 0.05};
  ImplicitContacts contacts{.scheme = scheme, .friction = friction};
  contacts.candidates = {{"ground", sphere, ContactHalfSpace{-1, {0, 0, 1}, -2}, 0.5, {}},
                         {"ball", sphere, ContactSphere{other, {3, 0.1, 2}, 0.2}, 0.3, {}},
                         {"pad", sphere, ContactHalfSpace{-1, {0.6, 0, 0.8}, -2}, 0, 200.0}};
  contacts.stops = {{1, -1, 2}, {2, -kUnlimited, 0.5}};
  contacts.frictions = {{0, 0.4}};
  if (planar) contacts.plane = Vector3<double>{0, 1, 0};
  Actuation actuation = Actuation::joints(*robot, {robot->joints[1].name, robot->joints[3].name});
  return std::make_shared<SteppingSystem>(std::make_shared<MultibodySystem>(robot, actuation),
                                          contacts);
}

}  // namespace conddp
