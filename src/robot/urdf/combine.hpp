#pragma once

#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// Several trees as one model, in the order given: coordinates one after the other.
///
/// Where a joint's or frame's name of one tree is also in another, the names of every tree that
/// clashes with an earlier one get its robot's name and a slash put before them ("arm/wrist"), with
/// a number where that is taken too ("arm_2/wrist"); trees given a prefix of their own when loaded
/// do not clash. Throws std::logic_error if there is no tree or if gravity differs.
RobotModel combine(std::vector<RobotModel> trees);

}  // namespace conddp
