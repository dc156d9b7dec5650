#pragma once

#include <filesystem>
#include <stdexcept>

#include "analysis/contact/contact_motion.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Settings for a problem file with a contact schedule.
struct ScheduleOptions {
  std::string solver = "proxddp";
  bool supports_constraints = true;  ///< true if constraints besides control bounds are supported
  std::filesystem::path folder;      ///< folder of the new file: its paths are relative to this
  std::filesystem::path solution;    ///< solution used as initial guess
  ContactSequenceOptions sequence;
};

struct ContactSchedule {
  OrderedJson problem;             ///< contents of the file
  std::vector<std::string> notes;  ///< aspects of the motion that the file omits
};

/// Thrown if a motion cannot be scheduled; the message gives the reason.
struct NoSchedule : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A problem with the costs, constraints and controls of the solved one, and with the contacts of
/// its motion as a schedule. It has a phase for each run of steps with the same closed candidates,
/// an impulse at each landing, and the motion as initial guess. Joint stops become bounds on
/// positions, friction becomes cones. For solvers without constraints, these and the problem's own
/// constraints become costs. For a box, only the faces that the motion touches or stays in front of
/// are used. Throws NoSchedule if the motion touches something that a contact of a problem file
/// cannot represent: a moving body, a soft wall, or a surface whose normal turns under the contact.
ContactSchedule contact_schedule(const BuiltProblem& built, const ContactMotion& motion,
                                 const ScheduleOptions& options);

}  // namespace conddp
