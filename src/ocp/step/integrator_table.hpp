#pragma once

#include <optional>
#include <string_view>

#include "systems/collocation_system.hpp"

namespace conddp {

/// How a knot's state is carried to the next one; a row of kIntegrators each.
enum class Integrator {
  none,
  impulse,
  semi_implicit_euler,
  explicit_euler,
  rk2,
  rk3,
  rk4,
  trapezoidal,
  hermite_simpson,
  radau3,
  radau5,
  discrete
};

/// An explicit Runge-Kutta rule: stage i starts at Σ a_ij k_j, the step is Σ b_i k_i. On curved
/// spaces it works in exponential coordinates at the knot's state (Munthe-Kaas), which keeps its
/// order.
struct RungeKuttaRule {
  int stages;
  double a[4][4];
  double b[4];
};

/// Of what kind a step is.
enum class StepKind {
  none,           ///< a terminal node has no step
  given,          ///< the system gives the next state itself
  impulse,        ///< it gives the next velocity; the configuration stays, the time step must be 0
  semi_implicit,  ///< the next velocity from the acceleration, the next position from that velocity
  runge_kutta,    ///< by `rule`
  collocation     ///< the implicit `collocation` rule of a CollocationSystem
};

/// What there is to know about an integrator.
struct IntegratorInfo {
  Integrator integrator;
  std::string_view name;         ///< in problem files; empty where no file can ask for it
  std::string_view description;  ///< one line, for people
  StepKind kind;
  int order = 0;  ///< of consistency in dt, where time passes
  RungeKuttaRule rule = {};
  std::optional<CollocationRule> collocation = {};
};

/// All integrators, in the order of the enumeration. Everything that distinguishes them is read
/// from here.
inline constexpr IntegratorInfo kIntegrators[] = {
    {Integrator::none, "", "", StepKind::none},
    {Integrator::impulse, "", "", StepKind::impulse},
    {Integrator::semi_implicit_euler, "semi_implicit_euler",
     "the next velocity from the acceleration, then the next position from it; first order, stable "
     "with contacts; the default of systems with positions and velocities",
     StepKind::semi_implicit, 1},
    {Integrator::explicit_euler,
     "explicit_euler",
     "first order",
     StepKind::runge_kutta,
     1,
     {1, {}, {1}}},
    {Integrator::rk2,
     "rk2",
     "midpoint rule, second order",
     StepKind::runge_kutta,
     2,
     {2, {{}, {0.5}}, {0, 1}}},
    {Integrator::rk3,
     "rk3",
     "Kutta's rule, third order",
     StepKind::runge_kutta,
     3,
     {3, {{}, {0.5}, {-1, 2}}, {1.0 / 6, 4.0 / 6, 1.0 / 6}}},
    {Integrator::rk4,
     "rk4",
     "the classical Runge-Kutta rule, fourth order; the default of first-order systems",
     StepKind::runge_kutta,
     4,
     {4, {{}, {0.5}, {0, 0.5}, {0, 0, 1}}, {1.0 / 6, 2.0 / 6, 2.0 / 6, 1.0 / 6}}},
    {Integrator::trapezoidal,
     "trapezoidal",
     "collocation by the trapezoidal rule: implicit, second order; needs a solver that enforces "
     "equality constraints",
     StepKind::collocation,
     2,
     {},
     CollocationRule::trapezoidal},
    {Integrator::hermite_simpson,
     "hermite_simpson",
     "collocation by Hermite and Simpson's rule (Lobatto IIIA): implicit, fourth order; same "
     "requirement",
     StepKind::collocation,
     4,
     {},
     CollocationRule::hermite_simpson},
    {Integrator::radau3,
     "radau3",
     "collocation by Radau's rule (IIA) of two stages: implicit, third order, damps stiff modes; "
     "same requirement",
     StepKind::collocation,
     3,
     {},
     CollocationRule::radau3},
    {Integrator::radau5,
     "radau5",
     "collocation by Radau's rule (IIA) of three stages: implicit, fifth order, damps stiff modes; "
     "same requirement",
     StepKind::collocation,
     5,
     {},
     CollocationRule::radau5},
    {Integrator::discrete, "discrete",
     "no integration, for systems that give the next state themselves (linear, car)",
     StepKind::given}};

constexpr const IntegratorInfo& info_of(Integrator integrator) {
  return kIntegrators[static_cast<int>(integrator)];
}

/// Whether a rule has q⁺ = q ⊕ dt v⁺, so that the derivative of v⁺ tells that of q⁺.
constexpr bool is_structured(Integrator integrator) {
  const StepKind kind = info_of(integrator).kind;
  return kind == StepKind::semi_implicit || kind == StepKind::impulse;
}

/// Whether a rule sees how controls change during a step. The midpoint rule sees their mean alone,
/// about which they could alternate unseen.
constexpr bool follows_controls(Integrator integrator) {
  const IntegratorInfo& info = info_of(integrator);
  return info.kind == StepKind::collocation ||
         (info.kind == StepKind::runge_kutta && info.rule.stages > 2);
}

/// Whether the enumeration and the table have the same order.
constexpr bool integrators_are_in_order() {
  int at = 0;
  for (const IntegratorInfo& info : kIntegrators)
    if (static_cast<int>(info.integrator) != at++) return false;
  return true;
}
static_assert(integrators_are_in_order());

}  // namespace conddp
