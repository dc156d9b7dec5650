#pragma once

#include "ocp/problem/problem.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// What stands behind the actuators in the controls of steps that find their contacts: the
/// accelerations of the guessed states, forces a little inside of their bounds, slacks as the
/// states have them or a little inside.
void guess_contacts(const std::shared_ptr<const SteppingSystem>& system,
                    const ShootingProblem& problem, Trajectory& trajectory);

/// What could be done with forces that hold the guessed states.
struct HeldGuess {
  int steps = 0;   ///< all of them
  int unheld = 0;  ///< those in which more than a thousandth of the weight is left
  int worst_knot = 0;
  double worst = 0;  ///< the most that is left of an equation of motion, N or Nm
};
/// The same with the actuators, and with forces that hold the robot as far as limits and gaps
/// allow; `product` is force times distance that the first relaxed solve admits, N m.
HeldGuess guess_held_contacts(const std::shared_ptr<const SteppingSystem>& system,
                              const ShootingProblem& problem, double product,
                              Trajectory& trajectory);

}  // namespace conddp
