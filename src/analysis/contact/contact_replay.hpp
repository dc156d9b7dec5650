#pragma once

#include <optional>

#include "analysis/certificate/replay.hpp"
#include "analysis/contact/contact_motion.hpp"
#include "analysis/contact/contact_simulator.hpp"

namespace conddp {

/// A contact-implicit motion, stepped anew by ContactSimulator.
struct ContactReplay {
  int substeps = 0;  ///< steps of the finer grid per planned step
  /// Every step from its own planned state, in the plan's contact mode if it has a solution.
  ReplayRun each_step;
  /// Steps of that run with a second solution, and the deviation of the worst such solution from
  /// the plan.
  int ambiguous_steps = 0;
  ReplayRun ambiguous;
  ReplayRun each_step_fine;                ///< the same in steps of h / substeps
  ReplayRun controls;                      ///< controls alone from the first state on, likewise
  ReplayRun controls_fine;                 ///< the same in steps of h / substeps
  std::optional<ReplayRun> feedback_fine;  ///< with gains, if the answer has any
};

/// `gains`: K, nu x ndx per knot of the problem, for all controls of a step; only the rows of the
/// actuators count.
ContactReplay replay_contacts(const ContactMotion& motion,
                              const std::vector<Eigen::MatrixXd>& gains, int substeps = 10);

}  // namespace conddp
