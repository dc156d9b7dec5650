#pragma once

#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// The joints (indices) along which nothing resists an acceleration, so that the joint-space
/// inertia matrix is singular in every configuration: a joint that moves no mass, a massless body
/// between two joints about one axis, a free body without rotational inertia.
std::vector<int> joints_without_inertia(const RobotModel& model);

}  // namespace conddp
