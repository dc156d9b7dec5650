#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// A contact of a file, whose frame and base are given as indices. Its reference is its placement.
Contact contact_of(const ContactSpec& spec, int frame, std::optional<int> base);

/// Goals that every posture of inverse kinematics meets: loops are closed (frames that every phase
/// holds together at a given placement), and the shapes of distances apart, of costs and
/// constraints alike. Leaves out what has errors: building the problem reports them.
KeptGoals kept_goals(const ProblemSpec& spec, const Plant& plant);

}  // namespace conddp
