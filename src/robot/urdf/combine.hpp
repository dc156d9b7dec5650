#pragma once

#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// Combines several trees into one model and concatenates their coordinates in the given order.
///
/// If a tree shares a joint or frame name with an earlier tree, all its names are prefixed by the
/// name of its robot and a slash ("arm/wrist"), with a number if that is taken too ("arm_2/wrist").
/// Trees loaded with a prefix of their own do not clash. Throws std::logic_error if there are no
/// trees or if gravity differs.
RobotModel combine(std::vector<RobotModel> trees);

}  // namespace conddp
