// Equality goals with the solver that enforces them in the stages; other requirements of the
// example problems are dropped.
#include <gtest/gtest.h>

#include "output/report/certificate_report.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

struct Goal {
  std::string problem;
  std::vector<std::string> drop;
};

class EqualityGoal : public ::testing::TestWithParam<Goal> {};

TEST_P(EqualityGoal, IsReachedAndCertified) {
  const Goal& goal = GetParam();
  Diagnostics out;
  const auto file = source_tree() / "problems" / (goal.problem + ".yaml");
  const auto spec = read_problem(file, {"solver.name=intro"}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {.drop = goal.drop}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SolverInfo& solver = *find_solver(spec->solver.name.value);
  const SolveResult result = solve(*built->problem, solver, spec->solver.options, built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const OrderedJson document =
      OrderedJson::parse(solution_json({*built, solver, result, {}}).dump());
  const SolutionCertificate certificate = certify_solution(document, *built, false);
  EXPECT_TRUE(certificate.checks.holds()) << certificate_table(certificate.checks);
}

INSTANTIATE_TEST_SUITE_P(Ready, EqualityGoal,
                         ::testing::Values(Goal{"cartpole_goal", {"force"}},
                                           Goal{"acrobot_goal", {"torque"}},
                                           Goal{"arm_maze", {"torque", "clear"}},
                                           Goal{"hopper_cycle", {"torque", "cone"}},
                                           Goal{"cartpole_collocation", {"force"}}),
                         [](const auto& test) { return test.param.problem; });

}  // namespace
}  // namespace conddp
