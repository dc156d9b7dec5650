#pragma once

#include "robot/data.hpp"

namespace conddp {

/// Memory of inverse_dynamics_gradient, per joint.
template <class S>
struct InverseDynamicsGradient {
  explicit InverseDynamicsGradient(const RobotModel& model);

  AlignedVector<Motion<S>> virtual_velocity;  ///< of the body, as w were generalised velocities
  AlignedVector<Force<S>> virtual_momentum;   ///< what the subtree's joints add of it
  AlignedVector<Vector3<S>> lever;  ///< of the subtree: wᵀτ by a common angular velocity
  /// nv each: gradients by configuration (tangent space), velocity and acceleration. The last one
  /// is M w.
  AlignedVector<S> wrt_q, wrt_v, wrt_a;
};

/// Gradient of wᵀτ for constant w (nv), with τ the inverse dynamics of data.acceleration, in O(nv):
/// the rows of inverse_dynamics_derivatives contracted on the way. Velocities and composite
/// inertias must be current. `applied` as there; the model's own external wrenches must be none.
template <class S>
void inverse_dynamics_gradient(const RobotModel& model, const S* v, const S* w, RobotData<S>& data,
                               const AlignedVector<Force<S>>* applied,
                               InverseDynamicsGradient<S>& out);

}  // namespace conddp
