#pragma once

#include "robot/data.hpp"

namespace conddp {

/// Workspace of inverse_dynamics_gradient, per joint.
template <class S>
struct InverseDynamicsGradient {
  explicit InverseDynamicsGradient(const RobotModel& model);

  AlignedVector<Motion<S>> virtual_velocity;  ///< of the body, if w were generalized velocities
  AlignedVector<Force<S>>
      virtual_momentum;  ///< contribution of the subtree's joints to the virtual momentum
  AlignedVector<Vector3<S>> lever;  ///< of the subtree: wᵀτ per common angular velocity
  /// nv each: gradients with respect to configuration (tangent space), velocity and acceleration.
  /// The last one is M w.
  AlignedVector<S> wrt_q, wrt_v, wrt_a;
};

/// Gradient of wᵀτ for constant w (nv), where τ is inverse dynamics at data.acceleration, in O(nv).
/// Contracts the rows of inverse_dynamics_derivatives as it computes them. Velocities and composite
/// inertias must be current. `applied` is as in that function; the model must not have external
/// wrenches of its own.
template <class S>
void inverse_dynamics_gradient(const RobotModel& model, const S* v, const S* w, RobotData<S>& data,
                               const AlignedVector<Force<S>>* applied,
                               InverseDynamicsGradient<S>& out);

}  // namespace conddp
