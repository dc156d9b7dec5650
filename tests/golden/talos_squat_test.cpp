// A squat of a humanoid from outside the product, compared with Crocoddyl's optimum of the same
// problem. Without the robot the test is skipped.
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/foreign_problems.hpp"

namespace conddp {
namespace {

TEST(TalosSquat, HasCrocoddylsOptimalCost) {
  const auto squat = talos_squat();
  if (!squat) GTEST_SKIP() << kNoForeignRobots;
  Diagnostics diagnostics;
  const auto spec = read_problem(squat->file, squat->settings, diagnostics);
  ASSERT_TRUE(spec) << format_diagnostics(diagnostics, false);
  const auto built = build_problem(*spec, {}, diagnostics);
  ASSERT_TRUE(built) << format_diagnostics(diagnostics, false);
  const SolveResult result = solve(*built->problem, "box_fddp", spec->solver.options, built->guess);
  EXPECT_EQ(result.status, SolveStatus::converged);
  // Crocoddyl 3.2.1, BoxFDDP with stop 1e-12, by scripts/peers/compare.
  EXPECT_NEAR(result.cost, 1.8951398092628775, 1e-7);
}

}  // namespace
}  // namespace conddp
