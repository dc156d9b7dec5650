#pragma once

#include <optional>

#include "analysis/certificate/replay.hpp"
#include "analysis/contact/contact_motion.hpp"
#include "analysis/contact/contact_simulator.hpp"

namespace conddp {

/// A motion with contacts that it found, stepped anew by ContactSimulator.
struct ContactReplay {
  int substeps = 0;  ///< of the finer grid
  /// Every step from its own planned state, in the plan's own contact mode where it has a solution.
  ReplayRun each_step;
  /// Steps of that run which have another solution than the one taken, and how far the worst of
  /// those is from the plan.
  int ambiguous_steps = 0;
  ReplayRun ambiguous;
  ReplayRun each_step_fine;                ///< the same in h / substeps
  ReplayRun controls;                      ///< the controls alone from the first state on, likewise
  ReplayRun controls_fine;                 ///< the same in h / substeps
  std::optional<ReplayRun> feedback_fine;  ///< with gains, where the answer has some
};

/// Gains are of all knots of the problem and all controls of a step, of which the actuators' rows
/// count: K, nu x ndx a knot.
ContactReplay replay_contacts(const ContactMotion& motion,
                              const std::vector<Eigen::MatrixXd>& gains, int substeps = 10);

}  // namespace conddp
