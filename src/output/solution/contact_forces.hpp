#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "ocp/problem/problem.hpp"
#include "problem_file/spec/spec.hpp"

namespace conddp {

/// The forces of all contacts of a problem along its trajectory, evaluated with scalar code.
struct ContactForces {
  struct OfContact {
    std::string name;
    bool torque = false;  ///< of a surface contact
    /// Per running knot: force (N) and torque (Nm) on the robot in world axes at the frame's
    /// origin; Ns and Nms at an impulse; nothing while the contact is not held.
    std::vector<std::optional<std::array<double, 6>>> wrench;
  };
  std::vector<OfContact> contacts;  ///< in the order of the file
};

ContactForces contact_forces(const ProblemSpec& spec, const ShootingProblem& problem,
                             const Trajectory& trajectory);

}  // namespace conddp
