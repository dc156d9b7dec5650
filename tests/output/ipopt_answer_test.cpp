// Traces of Ipopt's iterates in the answer.
#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

TEST(IpoptAnswer, EndsItsLogWithItsOwnGap) {
  // Ipopt leaves the free initial state outside its range by 1e-8 of the range.
  const SolvedExample answer(ProblemText{R"(conddp: 1
system: {type: unicycle}
initial_state: {values: {theta: 0.2452}}
integrator: rk2
phases:
  - {name: start, choose: [x, y], lower: -0.3, upper: 0.5}
  - {name: drive, knots: 7, dt: 0.0519, free_duration: {lower: 1.0e-3, upper: 10}}
costs:
  track: {residual: control, reference: [-0.1578, 0.7251], weight: 0.01271}
  effort: {residual: control, weight: 0.8939}
terminal:
  costs: {goal: {residual: combination, rows: {x: -0.2842}, weight: 1.41}}
initial_guess: {controls: {constant: 0.5019}}
solver: {name: ipopt}
)"});
  EXPECT_EQ(answer.result->log.back().gap, answer.result->residuals.gap);
  EXPECT_EQ(failures(answer.judge(answer.document)), "");
}

TEST(IpoptAnswer, MultipliersHaveCorrectSignsAfterEarlyStop) {
  const SolvedExample answer(ProblemText{R"(conddp: 1
robot:
  urdf: robots/free_body.urdf
  base: floating
  actuation:
    thrusters:
      - {name: push, frame: body, direction: [1, 0, 0], torque_ratio: 0.1, lower: -3, upper: 3}
      - {name: lift, frame: body, upper: 20}
      - {name: twist, frame: antenna, direction: [0, 1, 0], torque_ratio: -0.1, lower: -3,
         upper: null}
gravity: [0, 0, -3.7]
initial_state: {base: {position: [0, 0, 1], rpy: [0.1, 0, 0.2]}}
integrator: rk4
running_costs: sum
phases:
  - {name: start, choose: all}
  - {name: fly, knots: 2, dt: 0.005606, free_duration: {lower: 1.0e-3, upper: 10}}
costs:
  weak: {residual: control, weight: 540, weights: {u/twist: 1.294}}
  calm: {residual: centroidal_momentum, activation: {kind: smooth_l1, epsilon: 0.7628},
         weight: 0.0797}
constraints:
  thrust: {bounds: control, lower: -18.55, upper: 18.55}
  slow: {bounds: velocity, lower: -2.474, upper: 2.474, phases: fly}
  near: {residual: state, reference: initial, at_most: 2.317}
terminal:
  costs:
    there: {residual: frame_position, frame: antenna_mount, reference: [0.1734, -0.2181, -0.5055],
            activation: smooth_l1, weight: 554.7}
  constraints:
    spin: {residual: centroidal_momentum, equals: 0.1192}
initial_guess: {controls: {random: {seed: 17, scale: 0.2}}}
solver: {name: ipopt, max_iterations: 21}
)"});
  ASSERT_EQ(answer.result->status, SolveStatus::max_iterations);
  EXPECT_EQ(failures(answer.judge(answer.document)), "");
}

}  // namespace
}  // namespace conddp
