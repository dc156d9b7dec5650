#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Sets plant.systems, and what the plant says of variants, where phases have systems of their own,
/// or jumps lie between them. False, and reported, where systems do not fit each other, or a jump
/// is wrong.
bool add_systems_of_phases(const ProblemSpec& spec, Plant& plant, Diagnostics& out);

}  // namespace conddp
