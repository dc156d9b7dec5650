#pragma once

#include "output/mpc/loop_task.hpp"
#include "output/solution/contact_forces.hpp"

namespace conddp {

/// The contacts of a loop's file with so many rows of forces that there are not. Torques of soles
/// are left out: a plant that finds its contacts itself has forces at points.
ContactForces no_plant_forces(const LoopTask& task, int rows);

/// The contact forces of a loop's plant, a row a step: those that it found itself, otherwise those
/// of the contacts that the phases hold, where the step begins.
ContactForces plant_forces(const LoopTask& task, const ClosedLoopResult& result);

}  // namespace conddp
