#pragma once

#include <functional>

#include "problem_file/model/spec_mpc.hpp"

namespace conddp {

/// Predicate for ticks whose answer is late due to the loop's disturbances (MpcOptions::is_late);
/// null without such disturbances. For the same seed, the ticks drawn for a share are a subset of
/// those drawn for a larger share.
std::function<bool(int tick)> late_ticks(const MpcSpec& mpc);

}  // namespace conddp
