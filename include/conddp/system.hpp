// Dynamical systems: robots, closed forms, and systems of your own.
//
// What is there:
//   std::make_shared<const MultibodySystem>(robot, Actuation::full(*robot))
//   system->with_contacts(...)                        the same robot, held by contacts
//   pendulum({...}), cartpole({...}), unicycle(), ...  (all below)
//
// A system of your own derives from ClosedFormSystem and gives one formula, for any scalar:
//
//   class Crane : public ClosedFormSystem<Crane> {
//    public:
//     Crane() : ClosedFormSystem(SystemKind::second_order, StateManifold::flat(4), 1) {}
//     template <class S>
//     void rate(const S* x, const S* u, S* f) const {  // acceleration of (q, v) = x under u
//       ...
//     }
//   };
//
// `rate` is called with S = double, Lane (one knot per SIMD lane) and dual numbers, from which the
// exact Jacobians and Hessians follow. Hence it uses + − * / and sin, cos, exp, sqrt, ... without
// `std::`, and `select(condition, a, b)` where it would branch. What it writes depends on the kind:
//   second_order   x = (q, v): the accelerations, nv numbers
//   first_order    the rate of the state as a tangent vector, ndx numbers
//   discrete       the next state of a flat space, nx numbers
//   impulse        x = (q, v): the velocity after it, nv numbers
//
// x has nx numbers and a tangent vector ndx of them: on a curved space (StateManifold), such as
// poses with quaternions, ndx < nx. x ⊕ δx moves a state, x₁ ⊖ x₀ is the way between two.
//
// A system is immutable and shared by all knots. What changes while it is evaluated belongs to the
// solvers, so one system may serve several threads.
#pragma once

#include "systems/closed_form.hpp"
#include "systems/closed_forms/catalogue.hpp"
#include "systems/multibody/multibody.hpp"
#include "systems/state_manifold.hpp"
#include "systems/system.hpp"
