#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Sets plant.systems where phases have systems of their own, or jumps lie between them. False, and
/// reported, where these differ in their states or controls, or a jump is wrong.
bool add_systems_of_phases(const ProblemSpec& spec, Plant& plant, Diagnostics& out);

}  // namespace conddp
