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

/// Computes accelerations from generalized forces by factorization: M a = tau − bias. Writes M, L,
/// bias, acceleration. A null tau means zero forces.
template <class S>
void forward_dynamics(const RobotModel& model, const S* q, const S* v, const S* tau,
                      RobotData<S>& data);
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

}  // namespace conddp
