#pragma once

#include "robot/data.hpp"

namespace conddp {

/// A model's constant external wrenches. Their direction is fixed in the world, so that, unlike
/// inertial forces, they do not rotate with their bodies.

/// Subtracts the wrenches from data.force (per body, root frame); placements must be current.
template <class S>
void subtract_external_wrenches(const RobotModel& model, RobotData<S>& data);

/// Subtracts the derivative of Σ Jᵀ w with respect to the configuration from tau_q.
template <class S>
void subtract_external_wrench_derivatives(const RobotModel& model, RobotData<S>& data);

}  // namespace conddp
