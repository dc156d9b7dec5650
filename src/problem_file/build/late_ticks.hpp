#pragma once

#include <functional>

#include "problem_file/spec/spec_mpc.hpp"

namespace conddp {

/// Which ticks of a loop have an answer that comes too late by its disturbances (MpcOptions::
/// is_late); null where none of them says so. The ticks that a seed draws for a share are among
/// those that it draws for a larger one.
std::function<bool(int tick)> late_ticks(const MpcSpec& mpc);

}  // namespace conddp
