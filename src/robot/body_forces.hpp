#pragma once

#include "robot/kinematics.hpp"

namespace conddp {

/// Computes momentum and net inertial force of every body from its velocity and acceleration.
template <class S>
void body_forces(const RobotModel& model, RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    data.momentum[i] = data.body[i] * data.v[i];
    data.force[i] = data.body[i] * data.a[i] + cross(data.v[i], data.momentum[i]);
  }
}

/// Prepares the derivatives of inverse dynamics at data.acceleration, which sum from the tips to
/// the root. Writes for every body its momentum, its net force less `applied`, and the rate of its
/// inertia. Also updates the derivative columns of joints.
template <class S>
void start_inverse_dynamics_derivatives(const RobotModel& model, const S* v, RobotData<S>& data,
                                        const AlignedVector<Force<S>>* applied) {
  update_accelerations(model, v, data.acceleration.data(), data);
  update_derivative_columns(model, data);
  body_forces(model, data);
  if (applied != nullptr)
    for (int i = 0; i < model.joint_count(); ++i) data.force[i] = data.force[i] - (*applied)[i];
  for (int i = 0; i < model.joint_count(); ++i)
    data.inertia_rate[i] = rotational_inertia_rate(data.body[i], data.v[i]);
}

}  // namespace conddp
