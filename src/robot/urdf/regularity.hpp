#pragma once

#include <vector>

#include "robot/model.hpp"

namespace conddp {

/// Joints (indices) along which no inertia resists an acceleration, so that the joint-space inertia
/// matrix is singular in every configuration. Examples: a joint that moves no mass, a massless body
/// between two joints about one axis, a free body without rotational inertia.
std::vector<int> joints_without_inertia(const RobotModel& model);

/// Joints along which no inertia, or almost none, resists an acceleration at the zero
/// configuration, clamped to the joint limits. Axes that meet or align only there can make the
/// inertia matrix singular, although it is nonsingular elsewhere.
std::vector<int> joints_without_inertia_at_zero(const RobotModel& model);

/// Position nearest to zero within a joint's limits; zero for a joint without limits.
double zero_position(const Joint& joint);

/// Number of configurations that `joints_with_negative_inertia` samples.
inline constexpr int kRegularitySamples = 32;

/// Bodies (indices of joints, each with all links rigid with it) whose spatial inertia is not
/// positive semidefinite. If the list is empty, no eigenvalue of the joint-space inertia matrix is
/// negative in any configuration.
std::vector<int> bodies_with_negative_inertia(const RobotModel& model);

/// Joints with a negative articulated-body inertia (all joints further out move freely) along their
/// axis in at least one of `kRegularitySamples` configurations within the limits. The joint-space
/// inertia matrix is not positive definite there. Innermost first.
std::vector<int> joints_with_negative_inertia(const RobotModel& model);

}  // namespace conddp
