#pragma once

namespace conddp {

/// A long-running problem: many knots and unattainable tolerances.
inline constexpr const char* kLong = R"(conddp: 1
name: long
system: {type: acrobot}
initial_state: {values: {theta1: -1.5}}
phases: [{knots: 2000, dt: 0.005}]
costs: {effort: {residual: control, weight: 0.01}}
terminal: {costs: {up: {residual: state, reference: [1.57, 0, 0, 0], weight: 100}}}
initial_guess: {controls: {random: {seed: 1, scale: 1}}}
solver: {name: ilqr, max_iterations: 1000000, tolerances: {stationarity: 1e-300}}
)";

}  // namespace conddp
