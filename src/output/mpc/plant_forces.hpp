#pragma once

#include "output/mpc/loop_task.hpp"
#include "output/solution/contact_forces.hpp"

namespace conddp {

/// The contacts of a loop's file with `rows` empty rows of forces. Torques of surface contacts are
/// omitted: a contact-implicit plant has forces at points.
ContactForces no_plant_forces(const LoopTask& task, int rows);

/// Contact forces of a loop's plant, one row per step. A contact-implicit plant has its own;
/// otherwise they are those of the scheduled contacts, at the beginning of the step.
ContactForces plant_forces(const LoopTask& task, const ClosedLoopResult& result);

}  // namespace conddp
