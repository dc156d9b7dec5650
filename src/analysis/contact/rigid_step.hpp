#pragma once

#include <vector>

#include "robot/model.hpp"
#include "spatial/dual.hpp"

namespace conddp {

/// q⁺ = q ⊕ d for tangents d (h v⁺ of a step; nv numbers), written for checks alone: joints of one
/// degree of freedom add, floating bases turn and move along the screw of d in their own frame.
/// Defined for double and Dual<double>.
template <class S>
void move_configuration(const RobotModel& robot, const double* q, const S* d, S* moved);

/// d with q ⊕ d = to: of floating bases the screw between the two.
void configuration_difference(const RobotModel& robot, const double* q, const double* to,
                              double* d);

}  // namespace conddp
