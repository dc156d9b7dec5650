#pragma once

#include <memory>
#include <string>

#include "ocp/residuals/residuals.hpp"
#include "robot/urdf/urdf.hpp"
#include "support/small_problems.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp::testing {

/// A block of 2 kg on three slides along x, y, and z; the x and y slides weigh 1 kg each. Under a
/// push (u_x, u_y, u_z) it accelerates by u_x / 4, u_y / 3, and u_z / 2 − 9.81; the world holds it
/// with −u + (0, 0, 19.62). Limits along x: ±0.5 m, 1.5 m/s, 4 N; none along y and z.
inline std::shared_ptr<const RobotModel> block_on_slides() {
  const auto link = [](const std::string& name, int mass) {
    return "<link name=\"" + name + "\"><inertial><mass value=\"" + std::to_string(mass) +
           "\"/><inertia ixx=\"1\" iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" "
           "iyz=\"0\"/></inertial></link>\n";
  };
  const auto slide = [](const std::string& name, const std::string& parent,
                        const std::string& child, const std::string& axis,
                        const std::string& limit) {
    return "<joint name=\"" + name + "\" type=\"prismatic\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><axis xyz=\"" + axis + "\"/><limit " + limit +
           "/></joint>\n";
  };
  const std::string wide = R"(lower="-100" upper="100" velocity="100" effort="1000")";
  const UrdfResult urdf =
      parse_urdf("<robot name=\"slides\">\n<link name=\"world\"/>\n" + link("cart_x", 1) +
                     link("cart_y", 1) + link("block", 2) +
                     slide("x", "world", "cart_x", "1 0 0",
                           R"(lower="-0.5" upper="0.5" velocity="1.5" effort="4")") +
                     slide("y", "cart_x", "cart_y", "0 1 0", wide) +
                     slide("z", "cart_y", "block", "0 0 1", wide) + "</robot>\n",
                 "slides.urdf");
  return std::make_shared<const RobotModel>(urdf.model.value());
}

/// The block held by the world at contacts.
inline std::shared_ptr<const MultibodySystem> block_system(std::vector<Contact> contacts = {}) {
  const auto robot = block_on_slides();
  for (Contact& contact : contacts) contact.frame = *robot->find_frame("block");
  return std::make_shared<MultibodySystem>(robot, Actuation::full(*robot), PassiveForces{},
                                           std::move(contacts));
}

/// Knots of 0.1 s with semi-implicit Euler.
inline Phase block_phase(const std::shared_ptr<const MultibodySystem>& system, int knots,
                         double limit = kFree) {
  return tracking_phase(system, Integrator::semi_implicit_euler, knots, 0.1,
                        {.goal = std::vector<double>(6, 0.0),
                         .q = std::vector<double>(6, 1.0),
                         .r = std::vector<double>(3, 1.0)},
                        -limit, limit);
}

/// From rest at the origin.
inline ShootingProblem block_problem(std::vector<Phase> phases) {
  auto end =
      terminal_phase(phases.front().model->shared_system(),
                     {.goal = std::vector<double>(6, 0.0), .qf = std::vector<double>(6, 1.0)});
  return ShootingProblem(std::vector<double>(6, 0.0), std::move(phases), std::move(end));
}

}  // namespace conddp::testing
