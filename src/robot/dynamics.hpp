#pragma once

#include "robot/data.hpp"
#include "robot/kinematics.hpp"

namespace conddp {

/// Inverse dynamics (recursive Newton-Euler): the generalised forces that give accelerations a in
/// the state (q, v), less external wrenches. Writes tau and everything on its way.
template <class S>
void inverse_dynamics(const RobotModel& model, const S* q, const S* v, const S* a,
                      RobotData<S>& data);

/// Joint-space inertia matrix (composite rigid bodies, rotor inertias on the diagonal) into M.
/// Placements must be current; writes composite inertias too.
template <class S>
void mass_matrix(const RobotModel& model, RobotData<S>& data);

/// Factors M = Lᵀ D L along the tree, without fill-in (Featherstone 2008, table 6.3).
template <class S>
void factorize_mass_matrix(const RobotModel& model, RobotData<S>& data);
/// x ← M⁻¹ x with the factors, for right-hand sides that stand one after the other (nv x columns by
/// columns). Many at once cost much less than one by one.
template <class S>
void solve_mass_matrix(const RobotModel& model, const RobotData<S>& data, S* x, int columns = 1);

/// Coriolis, centrifugal, gravity forces less external wrenches into bias. Composite inertias
/// and velocities must be current.
template <class S>
void bias_forces(const RobotModel& model, const S* v, RobotData<S>& data);

/// Accelerations from generalised forces: M a = tau − bias, by factorisation. Writes M, L, bias,
/// acceleration. tau may be null for zero forces.
template <class S>
void forward_dynamics(const RobotModel& model, const S* q, const S* v, const S* tau,
                      RobotData<S>& data);
/// ∂τ/∂q (with respect to the tangent space) and ∂τ/∂v of inverse dynamics at
/// data.acceleration, into tau_q and tau_v (structural zeros stay zero). Velocities, composite
/// inertias and `acceleration` must be current. After Singh, Russell, Wensing (IEEE RA-L 2022),
/// with the product of their B matrix formed from composite momenta.
/// `applied`: forces on bodies (one a joint, in the root frame) that turn with their bodies.
template <class S>
void inverse_dynamics_derivatives(const RobotModel& model, const S* v, RobotData<S>& data,
                                  const AlignedVector<Force<S>>* applied = nullptr);

/// Gravity torques g(q) (nv) into out and, if asked for, their derivative (nv x nv by columns,
/// structural zeros are not written). Composite inertias must be current.
template <class S>
void gravity_torques(const RobotModel& model, const RobotData<S>& data, S* out, S* out_q);

/// Kinetic energy ½ vᵀ M v (J), rotors included; velocities and body inertias must be current.
template <class S>
S kinetic_energy(const RobotModel& model, const RobotData<S>& data);
/// Potential energy −Σ m gᵀ c (J); composite inertias must be current.
template <class S>
S potential_energy(const RobotModel& model, const RobotData<S>& data);

}  // namespace conddp
