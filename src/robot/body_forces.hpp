#pragma once

#include "robot/kinematics.hpp"

namespace conddp {

/// Momentum and net inertial force of every body from its velocity and acceleration.
template <class S>
void body_forces(const RobotModel& model, RobotData<S>& data) {
  for (int i = 0; i < model.joint_count(); ++i) {
    data.momentum[i] = data.body[i] * data.v[i];
    data.force[i] = data.body[i] * data.a[i] + cross(data.v[i], data.momentum[i]);
  }
}

/// Of every body alone, what derivatives of inverse dynamics at data.acceleration gather from the
/// tips to the root: momentum, net force but for what is `applied` and the rate of its inertia;
/// and the columns that joints give their subtrees.
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
