// Small problems on which solvers have failed or crawled: converged, at the same cost, within so
// many iterations.
#include <gtest/gtest.h>

#include "problem_file/build.hpp"
#include "problem_file/read_problem.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

struct HardCase {
  std::string name;
  std::string solver;
  double cost;
  int iterations;  ///< about twice those that it takes
};

class HardCases : public ::testing::TestWithParam<HardCase> {};

TEST_P(HardCases, AreSolvedInFewIterations) {
  const HardCase& c = GetParam();
  Diagnostics out;
  const auto spec = read_problem(
      std::filesystem::path(CONDDP_SOURCE_DIR) / "tests/golden/hard" / (c.name + ".yaml"), {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SolveResult result =
      solve(*built->problem, *find_solver(c.solver), spec->solver.options, built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.cost, c.cost, 1e-5 * c.cost);
  EXPECT_LE(result.iterations, c.iterations);
}

// Costs are those on which the three solvers agree.
INSTANTIATE_TEST_SUITE_P(
    Files, HardCases,
    ::testing::Values(HardCase{"disc_of_thrust", "ipopt", 6.45979751e-05, 30},
                      HardCase{"disc_of_thrust", "altro", 6.45979751e-05, 20},
                      HardCase{"disc_of_thrust", "proxddp", 6.45979751e-05, 20},
                      HardCase{"mars_landing", "ipopt", 399.174711, 160},
                      HardCase{"mars_landing", "altro", 399.174711, 80},
                      HardCase{"mars_landing", "proxddp", 399.174711, 80},
                      HardCase{"mars_landing_free", "ipopt", 398.061102, 100},
                      HardCase{"mars_landing_free", "altro", 398.061102, 100},
                      HardCase{"mars_landing_free", "proxddp", 398.061102, 100}),
    [](const auto& test) { return test.param.name + "_" + test.param.solver; });

}  // namespace
}  // namespace conddp
