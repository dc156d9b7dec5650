#pragma once

#include <optional>

#include "analysis/contact_motion.hpp"
#include "analysis/contact_simulator.hpp"
#include "analysis/replay.hpp"

namespace conddp {

/// A motion with contacts that it found, stepped anew by ContactSimulator.
struct ContactReplay {
  int substeps = 0;     ///< of the finer grid
  ReplayRun each_step;  ///< every step from its own planned state: as the plan's own grid has it
  ReplayRun each_step_fine;  ///< the same in h / substeps
  ReplayRun controls;        ///< the controls alone from the first state on, with the plan's h
  ReplayRun controls_fine;   ///< the same in h / substeps
  std::optional<ReplayRun> feedback_fine;  ///< with gains, where the answer has some
};

/// Gains are of all controls of a step, of which the actuators' rows count: K, nu x ndx a step.
ContactReplay replay_contacts(const ContactMotion& motion,
                              const std::vector<Eigen::MatrixXd>& gains, int substeps = 10);

}  // namespace conddp
