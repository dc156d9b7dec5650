#pragma once

namespace conddp {

/// A cart-pole near its upright state: the part of a problem file from its system to its solver.
inline constexpr const char* kBalancing = R"(system: {type: cartpole}
initial_state: {values: {theta: 2.9}}
integrator: rk4
phases: [{name: balance, knots: 20, dt: 0.05}]
costs:
  state: {residual: state, reference: {values: {theta: 3.141592653589793}}}
  effort: {residual: control, weight: 0.1}
constraints: {force: {bounds: control, lower: -10, upper: 10}}
terminal:
  costs: {upright: {residual: state, reference: {values: {theta: 3.141592653589793}}, weight: 20}}
solver: {name: box_fddp}
)";

}  // namespace conddp
