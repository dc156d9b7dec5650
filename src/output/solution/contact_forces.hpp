#pragma once

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ocp/problem/node_values.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Forces of all contacts of a problem along its trajectory, evaluated with scalar code.
struct ContactForces {
  struct OfContact {
    std::string name;
    bool torque = false;  ///< true for a surface contact
    /// Per running knot: force (N) and torque (Nm) on the robot in world axes at the frame's
    /// origin; Ns and Nms at an impulse; empty while the contact is open.
    std::vector<std::optional<std::array<double, 6>>> wrench;
  };
  std::vector<OfContact> contacts;  ///< in the order of the file
};

ContactForces contact_forces(const BuiltProblem& built, const NodeValues& values);

/// The contacts of a file with `rows` empty rows of forces.
ContactForces no_contact_forces(const BuiltProblem& built, int rows);

/// Evaluates the contact forces of a system row by row.
class ContactForceWriter {
 public:
  /// Writes a row: the forces of a system's contacts at a state and a control.
  void write(const System& system, const double* x, const double* u, int row, ContactForces& to);

 private:
  std::map<const System*, std::unique_ptr<SystemData<double>>> memory_;
};

}  // namespace conddp
