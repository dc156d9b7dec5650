// Wherever a solve stops, the last row of its log is its answer.
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// Stops an example problem after each number of iterations in turn.
void expect_answers_in_logs(const std::string& name) {
  Diagnostics out;
  const auto spec = read_problem(source_tree() / "problems" / (name + ".yaml"), {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  SolverOptions options = spec->solver.options;
  SolveStatus status = SolveStatus::max_iterations;
  for (int i = 0; status == SolveStatus::max_iterations; ++i) {
    options.max_iterations = i;
    const SolveResult result =
        solve(*built->problem, spec->solver.name.value, options, built->guess);
    status = result.status;
    ASSERT_FALSE(result.log.empty());
    const IterationRecord& last = result.log.back();
    EXPECT_EQ(last.iteration, result.iterations) << i;
    EXPECT_NEAR(last.cost, result.cost, 1e-12 * (1 + std::abs(result.cost))) << i;
    EXPECT_NEAR(last.gap, result.residuals.gap, 1e-12) << i;
  }
  EXPECT_EQ(status, SolveStatus::converged);
}

TEST(EndOfTheLog, IsTheAnswerAfterRejectedNewtonSteps) { expect_answers_in_logs("hopper_cycle"); }

}  // namespace
}  // namespace conddp
