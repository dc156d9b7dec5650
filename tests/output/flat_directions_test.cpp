// Answers with costs that hardly depend on a control or on a free initial coordinate. Gains there
// are large or rounding, and the certificate still holds.
#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

/// The car's acceleration affects only the last cost, and its steering nothing.
constexpr const char* kIdleControls = R"(conddp: 1
system: {type: car, wheelbase: 2.141}
initial_state: {}
running_costs: sum
phases: [{name: drive, knots: 9, dt: 0.02513}]
costs:
  rate: {residual: control_rate, weight: 0.00376,
         activation: {kind: quadratic_barrier, lower: -0.01116, upper: 0.2852}}
  effort: {residual: control, weight: 103.9,
           activation: {kind: quadratic_barrier, lower: -0.1872, upper: 0.3249}}
terminal:
  costs: {goal: {residual: state, columns: [x, v], reference: [0.08485, 0.5622], weight: 7.145}}
initial_guess: {controls: {constant: -0.5874}}
solver: {name: box_fddp}
)";

TEST(FlatDirections, CostatesOfIdleControlsAreCertified) {
  const SolvedExample answer(ProblemText{kIdleControls});
  ASSERT_EQ(answer.result->status, SolveStatus::converged) << answer.result->message;
  EXPECT_EQ(failures(answer.judge(answer.document)), "");
}

TEST(FlatDirections, WrongCostatesAreNotCertified) {
  const SolvedExample answer(ProblemText{kIdleControls});
  OrderedJson document = answer.document;
  add_to(document["multipliers"]["costates"][4][0], 0.02);
  EXPECT_NE(failures(answer.judge(document)).find("[status]"), std::string::npos);
}

TEST(FlatDirections, GainsOfIdleFirstStateAllowForRounding) {
  // Only the cycle cost depends on the quadrotor's start, and it moves along.
  const SolvedExample answer(ProblemText{R"(conddp: 1
system: {type: quadrotor, mass: 0.5692, jz: 0.005131, arm: 0.1925}
initial_state: {values: {wz: 0.003261}}
phases:
  - {name: start, choose: all}
  - {name: rise, knots: 2, dt: 0.04367}
  - {name: fly, knots: 2, duration: 0.08734}
  - {name: end, knots: 3, duration: 0.131}
costs:
  cycle: {residual: cycle, weight: 0.03138}
  effort: {residual: control, weight: 0.1718}
constraints:
  near: {residual: control, reference: [0.6444, 0.5792, -0.6823, -0.3277], at_most: 0.398,
         soft: l2, weight: 19.69, phases: fly}
terminal:
  constraints:
    fast: {residual: combination, at_least: 0.1469, soft: l2, weight: 14.08,
           rows: [{wy: -0.5922, wz: -0.8452}, {vz: 1.635, constant: 0.1889}]}
initial_guess: {states: initial, controls: quasi_static}
solver: {name: box_fddp, max_iterations: 22}
)"});
  EXPECT_EQ(failures(answer.judge(answer.document)), "");
}

}  // namespace
}  // namespace conddp
