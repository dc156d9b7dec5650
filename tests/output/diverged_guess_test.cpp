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

}  // namespace
}  // namespace conddp
