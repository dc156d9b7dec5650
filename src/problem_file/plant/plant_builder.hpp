#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Loads the robots or makes the closed-form system. Notes of the URDF files (what is ignored) are
/// reported as well.
std::optional<Plant> build_plant(const ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
