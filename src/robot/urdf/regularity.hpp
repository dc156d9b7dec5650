#pragma once

#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// The joints (indices) along which nothing resists an acceleration, so that the joint-space
/// inertia matrix is singular in every configuration: a joint that moves no mass, a massless body
/// between two joints about one axis, a free body without rotational inertia.
std::vector<int> joints_without_inertia(const RobotModel& model);

/// The same, or nearly so, at the zero configuration alone, clamped to the joint limits: axes that
/// meet or align there can leave nothing that resists, though it does elsewhere.
std::vector<int> joints_without_inertia_at_zero(const RobotModel& model);

/// The position within a joint's limits that is nearest to zero; zero where there are none.
double zero_position(const Joint& joint);

/// How many configurations `joints_with_negative_inertia` looks at.
inline constexpr int kRegularitySamples = 32;

/// Bodies (indices of joints, each with all links that are rigid with it) whose spatial inertia is
/// not positive semidefinite. Without such a body the joint-space inertia matrix has no negative
/// eigenvalue in any configuration.
std::vector<int> bodies_with_negative_inertia(const RobotModel& model);

/// The joints along which an acceleration meets a negative inertia, if what is further out moves
/// freely, in one of `kRegularitySamples` configurations within the limits: there the joint-space
/// inertia matrix is not positive definite. Innermost first.
std::vector<int> joints_with_negative_inertia(const RobotModel& model);

}  // namespace conddp
