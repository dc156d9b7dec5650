#include <fmt/format.h>
#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "support/solved_example.hpp"

namespace conddp {
namespace {

TEST(DivergedGuess, HasTheViolationsOfTheGuess) {
  const SolvedExample answer(ProblemText{R"(conddp: 1
system: {type: double_integrator}
initial_state: {values: {q/0: 1}}
phases: [{name: only, knots: 5, dt: 0.1}]
costs: {effort: {residual: control}}
constraints: {ahead: {bounds: state, lower: {q/0: 0.05}, soft: l2, weight: 1}}
initial_guess: {controls: {constant: 1.0e+300}}
solver: {name: ilqr}
)"});
  ASSERT_EQ(answer.result->status, SolveStatus::diverged);
  ASSERT_FALSE(answer.document["soft_constraints"].empty());
  for (const OrderedJson& constraint : answer.document["soft_constraints"])
    EXPECT_EQ(constraint["violation"], 0) << "the guess stands at 1";
  EXPECT_EQ(failures(answer.judge(answer.document)), "");
}

TEST(DivergedGuess, HasGuessConstraintsIfDynamicsHaveNoValue) {
  for (const char* solver : {"altro", "proxddp"}) {
    const SolvedExample answer(ProblemText{fmt::format(R"(conddp: 1
system: {{states: [x, v], controls: [u], rate: {{x: v, v: u/(x - x)}}}}
initial_state: {{values: {{x: 0.1}}}}
phases: [{{knots: 20, duration: 1}}]
costs: {{effort: {{residual: control}}}}
constraints: {{box: {{bounds: state, lower: {{x: -1}}}}}}
terminal: {{constraints: {{there: {{residual: state, columns: x, reference: 1}}}}}}
solver: {{name: {}}}
)",
                                                       solver)});
    ASSERT_EQ(answer.result->status, SolveStatus::diverged) << solver;
    EXPECT_EQ(answer.result->constraint_values[0], 0.1) << solver;
    EXPECT_EQ(failures(answer.judge(answer.document)), "") << solver;
  }
}

TEST(DivergedGuess, HasNoLogIfCostatesAreNotFinite) {
  for (const char* solver : {"ddp", "fddp", "box_fddp", "intro", "altro", "proxddp"}) {
    const SolvedExample answer(ProblemText{fmt::format(R"(conddp: 1
system: {{states: [p], controls: [u], rate: {{p: 1e60*p + u}}}}
initial_state: {{values: {{p: 1}}}}
phases: [{{knots: 20, dt: 0.02}}]
costs: {{track: {{residual: state}}, effort: {{residual: control, weight: 0.01}}}}
initial_guess: {{states: initial}}
solver: {{name: {}, max_iterations: 5}}
)",
                                                       solver)});
    EXPECT_EQ(answer.result->status, SolveStatus::diverged) << solver;
    EXPECT_TRUE(answer.result->log.empty()) << solver;
    EXPECT_EQ(failures(answer.judge(answer.document)), "") << solver;
  }
}

}  // namespace
}  // namespace conddp
