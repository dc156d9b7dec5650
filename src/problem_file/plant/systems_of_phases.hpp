#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Sets plant.systems and the plant's variants if phases have different systems or jumps lie
/// between them. Returns false with an error for incompatible systems or an invalid jump.
bool add_systems_of_phases(const ProblemSpec& spec, Plant& plant, Diagnostics& out);

}  // namespace conddp
