// Steps with hard cones from initial states above the ground, where active cone rows keep changing.
#include <gtest/gtest.h>

#include "analysis/comparison/benchmark.hpp"
#include "analysis/comparison/random_instance.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

class PerturbedStep : public ::testing::TestWithParam<const char*> {};

TEST_P(PerturbedStep, IsSolved) {
  Diagnostics out;
  const auto spec = read_problem(source_tree() / "problems/biped_step_cones.yaml",
                                 {std::string("solver.name=") + GetParam()}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  SolverOptions options = spec->solver.options;
  options.max_iterations = 600;
  for (const std::uint64_t seed : {2, 5, 8}) {
    const ShootingProblem problem = perturb_initial_state(*built->problem, 0.1, seed);
    const SolveResult result = solve(problem, GetParam(), options, built->guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    const AnswerCheck check = check_answer(
        problem, result.trajectory, options.tolerances.constraint, result.constraint_multipliers);
    EXPECT_LE(check.stationarity, 10 * options.tolerances.stationarity) << seed;
    EXPECT_LE(check.constraint, 10 * options.tolerances.constraint) << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(Solvers, PerturbedStep, ::testing::Values("altro", "proxddp"),
                         [](const auto& test) { return std::string(test.param); });

}  // namespace
}  // namespace conddp
