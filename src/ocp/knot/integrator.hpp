#pragma once

#include <optional>
#include <vector>

#include "systems/collocation_system.hpp"

namespace conddp {

/// How a knot's state is carried to the next one, controls constant over the knot.
/// `none`: a terminal node. `discrete`: the system gives the next state itself. `impulse`: the
/// system gives the next velocity, the configuration stays, and the time step must be 0.
/// `rk2` is the midpoint rule, `rk3` Kutta's (1/6, 4/6, 1/6). On curved spaces Runge-Kutta rules
/// work in exponential coordinates at the knot's state (Munthe-Kaas), which keeps their order.
/// `trapezoidal` and `hermite_simpson` are the implicit rules of a CollocationSystem.
enum class Integrator {
  none,
  discrete,
  impulse,
  semi_implicit_euler,
  explicit_euler,
  rk2,
  rk3,
  rk4,
  trapezoidal,
  hermite_simpson
};

/// An explicit Runge-Kutta rule: stage i starts at Σ a_ij k_j, the step is Σ b_i k_i.
struct RungeKuttaRule {
  int stages;
  double a[4][4];
  double b[4];
};
/// The rule of explicit_euler, rk2, rk3 or rk4.
const RungeKuttaRule& runge_kutta_rule(Integrator integrator);
/// The rule that a CollocationSystem needs for it; of trapezoidal and hermite_simpson alone.
std::optional<LobattoRule> lobatto_rule(Integrator integrator);

/// Memory of an integrator for one knot of a system.
template <class S>
struct IntegratorWorkspace {
  /// `by_step`: with the derivative by dt, a further column of F. Not of impulses and discrete
  /// systems, which know no dt.
  IntegratorWorkspace(const System& system, Integrator integrator, bool by_step = false);

  AlignedVector<S> next;          ///< nx
  AlignedVector<S> F;             ///< rows x columns by columns, see integrate_derivatives
  int columns;                    ///< nz, or nz + 1 with the derivative by dt
  AlignedVector<S> state_blocks;  ///< structured rules: ∂q⁺/∂q per curved segment (by rows)
  AlignedVector<S> step_blocks;   ///< structured rules: ∂q⁺/∂(dt v⁺) per curved segment

  AlignedVector<S> tangent;  ///< ndx
  struct Stage {
    AlignedVector<S> theta, x, rate, k;  ///< displacement from the knot, state there, ẋ, θ̇
    AlignedVector<S> Theta, X, K;        ///< derivatives of theta, x, k, ndx x columns
  };
  std::vector<Stage> stages;
  AlignedVector<S> wrt_x, wrt_dx, inverse;  ///< blocks per curved segment
  AlignedVector<Dual<S>> dual_theta, dual_inverse;
};

/// One step: writes work.next. The system's data must have been evaluated at (x, u) already; rules
/// with further stages evaluate it elsewhere afterwards.
template <class S>
void integrate(const System& system, Integrator integrator, const S* x, const S* u, const S& dt,
               SystemData<S>& data, IntegratorWorkspace<S>& work);

/// Whether a rule has q⁺ = q ⊕ dt v⁺, so that the derivative of v⁺ tells that of q⁺.
inline bool is_structured(Integrator integrator) {
  return integrator == Integrator::semi_implicit_euler || integrator == Integrator::impulse;
}

/// The same with the derivative of the step with respect to z = (tangent at x, u) in work.F: for
/// structured rules the nv rows of the next velocity (the blocks tell the rest), else all ndx
/// rows. The system's data must have been differentiated at (x, u). The column by dt follows where
/// the workspace has one: of structured rules that of the next velocity, too.
template <class S>
void integrate_derivatives(const System& system, Integrator integrator, const S* x, const S* u,
                           const S& dt, SystemData<S>& data, IntegratorWorkspace<S>& work);

}  // namespace conddp
