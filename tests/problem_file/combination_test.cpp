#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

std::string with_line(const std::string& constraint) {
  return replaced(replaced(kPendulum, "name: box_ddp", "name: altro"), "constraints:\n",
                  "constraints:\n  line: " + constraint + "\n");
}

TEST(Combination, AddsFactorsTimesColumns) {
  const Loaded loaded(
      with_line("{residual: combination, rows: [{omega: 2, theta: -1, constant: 0.5}, "
                "{torque: 3, theta: 1}], upper: [1, 4], knots: [2]}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  ASSERT_EQ(problem.constraints().size(), 1u);
  const NodeConstraint& c = problem.constraints()[0];
  EXPECT_EQ(c.upper[1], 4);
  Trajectory t = problem.create_trajectory();
  t.x(2) << 0.7, -1.1;
  t.u(2)[0] = 0.2;
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(t, evaluation);
  EXPECT_DOUBLE_EQ(evaluation.constraint[c.row], 2 * -1.1 - 0.7 + 0.5);
  EXPECT_DOUBLE_EQ(evaluation.constraint[c.row + 1], 3 * 0.2 + 0.7);
  for (const DerivativeComparison& d : check_derivatives(problem, t)) EXPECT_LT(d.error, 1e-9);
}

TEST(Combination, HoldsAtASolution) {
  const Loaded loaded(with_line(
      "{residual: combination, rows: {torque: 1, omega: 1}, upper: 0.5, phases: second}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const SolveResult result = solve(problem, "altro", {}, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  double largest = 0;
  for (int k = 4; k < 10; ++k)
    largest = std::max(largest, result.trajectory.u(k)[0] + result.trajectory.x(k)[1]);
  EXPECT_NEAR(largest, 0.5, 1e-6) << "it is active";
}

}  // namespace
}  // namespace conddp
