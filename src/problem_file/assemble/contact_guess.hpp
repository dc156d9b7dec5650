#pragma once

#include "ocp/problem/problem.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// Fills the controls after the actuators in contact-implicit steps: accelerations from the guessed
/// states, forces slightly inside their bounds, and slacks from the states or slightly inside.
void guess_contacts(const std::shared_ptr<const SteppingSystem>& system,
                    const ShootingProblem& problem, Trajectory& trajectory);

/// Result of holding the guessed states with forces.
struct HeldGuess {
  int steps = 0;   ///< number of steps
  int unheld = 0;  ///< steps with a residual above a thousandth of the weight
  int worst_knot = 0;
  double worst = 0;  ///< largest residual of an equation of motion, N or Nm
};
/// Like guess_contacts, but also sets the actuators, and forces that hold the robot as far as
/// limits and gaps allow. `product`: force times distance that the first relaxed solve allows, N m.
HeldGuess guess_held_contacts(const std::shared_ptr<const SteppingSystem>& system,
                              const ShootingProblem& problem, double product,
                              Trajectory& trajectory);

}  // namespace conddp
