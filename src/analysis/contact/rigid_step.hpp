#pragma once

#include <vector>

#include "robot/model.hpp"
#include "spatial/dual.hpp"

namespace conddp {

/// q⁺ = q ⊕ d for tangent vectors d (h v⁺ of a step; nv numbers), used by checks only. Joints with
/// one degree of freedom add; floating bases turn and move along the screw of d in their own frame.
/// Defined for double and Dual<double>.
template <class S>
void move_configuration(const RobotModel& robot, const double* q, const S* d, S* moved);

/// Solves q ⊕ d = to for d; for floating bases, d is the screw between the two poses.
void configuration_difference(const RobotModel& robot, const double* q, const double* to,
                              double* d);

}  // namespace conddp
