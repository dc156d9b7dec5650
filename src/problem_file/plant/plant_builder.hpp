#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Loads the robots or makes the closed-form system. Also reports notes on the URDF files, such as
/// ignored elements.
std::optional<Plant> build_plant(const ProblemSpec& spec, Diagnostics& out);

}  // namespace conddp
