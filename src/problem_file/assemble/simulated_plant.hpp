#pragma once

#include "mpc/plant_motion.hpp"
#include "problem_file/assemble/build.hpp"

namespace conddp {

/// Maximum number of simulated contacts: the number of bits in PlantMotion::closed_contacts().
inline constexpr int kMostSimulatedContacts = 32;

/// The plant of a closed loop with simulated contacts (mpc.plant). Every contact of the file, with
/// its friction, may touch every shape of the ground; soles touch at their corners. Null, with a
/// report, if the file cannot be simulated this way.
std::shared_ptr<PlantMotion> simulated_plant(const BuiltProblem& built, Diagnostics& out);

/// Warns if contacts of the first phase start above the ground, or any contact inside it.
void check_standing(const BuiltProblem& built, Diagnostics& out);

}  // namespace conddp
