#pragma once

#include <filesystem>
#include <stdexcept>

#include "analysis/contact/contact_sequence.hpp"
#include "base/json/ordered_json.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// What is asked of a problem file with a schedule of contacts.
struct ScheduleOptions {
  std::string solver = "proxddp";
  bool supports_constraints = true;  ///< whether it takes constraints besides bounds on the control
  std::filesystem::path folder;  ///< in which the file will stand: paths in it are relative to that
  std::filesystem::path solution;  ///< that it starts from
  ContactSequenceOptions sequence;
};

struct ContactSchedule {
  OrderedJson problem;             ///< of the file
  std::vector<std::string> notes;  ///< what of the motion it does not say
};

/// A motion has no schedule; says why.
struct NoSchedule : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// A problem with the costs, constraints and controls of the one that was solved, in which the
/// contacts that its motion found are scheduled: a phase for each run of steps with the same closed
/// candidates, an impulse where some of them land, and the motion as first guess. Stops of joints
/// become bounds on their positions, friction becomes cones. For solvers that keep no constraints
/// these and the problem's own become costs. Of a box the faces count that the motion touches or
/// stays in front of. Throws NoSchedule where the motion touches something that no contact of a
/// problem file can be: what moves, a soft wall, a surface whose normal turns under the contact.
ContactSchedule contact_schedule(const ProblemSpec& spec, const BuiltProblem& built,
                                 const ContactMotion& motion, const ScheduleOptions& options);

}  // namespace conddp
