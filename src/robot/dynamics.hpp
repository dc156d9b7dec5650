#pragma once

#include "robot/data.hpp"
#include "robot/kinematics.hpp"

namespace conddp {

/// Inverse dynamics (recursive Newton-Euler): the generalized forces that give accelerations a in
/// the state (q, v), less external wrenches. Writes tau and all intermediate results.
template <class S>
void inverse_dynamics(const RobotModel& model, const S* q, const S* v, const S* a,
                      RobotData<S>& data);

/// Writes the joint-space inertia matrix (composite rigid bodies, rotor inertias on the diagonal)
/// into M. Placements must be current; also writes composite inertias.
template <class S>
void mass_matrix(const RobotModel& model, RobotData<S>& data);

/// Factors M = Lᵀ D L along the tree, without fill-in (Featherstone 2008, table 6.3).
template <class S>
void factorize_mass_matrix(const RobotModel& model, RobotData<S>& data);
/// x ← M⁻¹ x with the factors, for contiguous right-hand sides (nv x columns by columns). Many
/// together cost much less than one by one.
template <class S>
void solve_mass_matrix(const RobotModel& model, const RobotData<S>& data, S* x, int columns = 1);

/// Writes Coriolis, centrifugal and gravity forces less external wrenches into bias. Composite
/// inertias and velocities must be current.
template <class S>
void bias_forces(const RobotModel& model, const S* v, RobotData<S>& data);

/// Writes ∂τ/∂q (with respect to the tangent space) and ∂τ/∂v of inverse dynamics at
/// data.acceleration into tau_q and tau_v; structural zeros stay zero. Velocities, composite
/// inertias and `acceleration` must be current. After Singh, Russell, Wensing (IEEE RA-L 2022),
/// with the product of their B matrix formed from composite momenta. `applied` are forces on bodies
/// that rotate with their bodies (one per joint, in the root frame).
template <class S>
void inverse_dynamics_derivatives(const RobotModel& model, const S* v, RobotData<S>& data,
                                  const AlignedVector<Force<S>>* applied = nullptr);

/// Writes gravity torques g(q) (nv) into out and, if requested, their derivative into out_q (nv x
/// nv by columns; structural zeros are not written). Composite inertias must be current.
template <class S>
void gravity_torques(const RobotModel& model, const RobotData<S>& data, S* out, S* out_q);

/// Kinetic energy ½ vᵀ M v (J), rotors included; velocities and body inertias must be current.
template <class S>
S kinetic_energy(const RobotModel& model, const RobotData<S>& data);
/// Potential energy −Σ m gᵀ c (J); composite inertias must be current.
template <class S>
S potential_energy(const RobotModel& model, const RobotData<S>& data);

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
