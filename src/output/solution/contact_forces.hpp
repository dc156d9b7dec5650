#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ocp/problem/node_values.hpp"
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
                             const NodeValues& values);

/// The contacts of a file with so many rows of forces that there are not.
ContactForces no_contact_forces(const ProblemSpec& spec, int rows);

/// Evaluates the forces that a system's contacts have, row by row.
class ContactForceWriter {
 public:
  /// Writes a row: the forces of the contacts that a system holds, in a state with a control.
  void write(const System& system, const double* x, const double* u, int row, ContactForces& to);

 private:
  std::map<const System*, std::unique_ptr<SystemData<double>>> memory_;
};

}  // namespace conddp
