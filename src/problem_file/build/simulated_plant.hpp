#pragma once

#include "mpc/plant_motion.hpp"
#include "problem_file/build/build.hpp"

namespace conddp {

/// More contacts than that have no bits in PlantMotion::closed_contacts().
inline constexpr int kMostSimulatedContacts = 32;

/// The plant of a closed loop with simulated contacts (mpc.plant): every contact of the file may
/// touch every shape of the ground, with its friction, a sole at its corners. Null where that has
/// no meaning, which is reported.
std::shared_ptr<PlantMotion> simulated_plant(const ProblemSpec& spec, const BuiltProblem& built,
                                             Diagnostics& out);

/// Warns where contacts of the first phase are above the ground or in it at the start.
void check_standing(const ProblemSpec& spec, const BuiltProblem& built, Diagnostics& out);

}  // namespace conddp
