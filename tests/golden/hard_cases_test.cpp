// Problems on which solvers failed or were slow: they converge to the same cost.
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

struct HardCase {
  std::string name;
  std::filesystem::path file;
  std::vector<std::string> settings;
  std::string solver;
  double cost;
  double tolerance = 1e-5;  ///< relative, of the cost: local optima may be nearby
};

HardCase small(const std::string& name, const std::string& solver, double cost) {
  return {name, "tests/golden/hard/" + name + ".yaml", {}, solver, cost};
}

class HardCases : public ::testing::TestWithParam<HardCase> {};

TEST_P(HardCases, AreSolved) {
  const HardCase& c = GetParam();
  Diagnostics out;
  const auto spec = read_problem(source_tree() / c.file, c.settings, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SolveResult result =
      solve(*built->problem, *find_solver(c.solver), spec->solver.options, built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.cost, c.cost, c.tolerance * c.cost);
}

// Costs on which several solvers agree.
INSTANTIATE_TEST_SUITE_P(Files, HardCases,
                         ::testing::Values(small("disc_of_thrust", "ipopt", 6.45979751e-05),
                                           small("disc_of_thrust", "altro", 6.45979751e-05),
                                           small("disc_of_thrust", "proxddp", 6.45979751e-05),
                                           small("mars_landing", "ipopt", 399.174711),
                                           small("mars_landing", "altro", 399.174711),
                                           small("mars_landing", "proxddp", 399.174711),
                                           small("mars_landing_free", "ipopt", 398.061102),
                                           small("mars_landing_free", "altro", 398.061102),
                                           small("mars_landing_free", "proxddp", 398.061102),
                                           small("sled", "ipopt", 4.51453061),
                                           small("sled", "ipddp", 4.51453061)),
                         [](const auto& test) {
                           return test.param.name + "_" + test.param.solver;
                         });

// The kink of the cost at zero has a thousand times the curvature at the answer.
HardCase from_zero(const std::string& name, const std::string& solver, double cost) {
  return {
      name, "tests/golden/hard/" + name + ".yaml", {"initial_guess.controls=zero"}, solver, cost};
}

INSTANTIATE_TEST_SUITE_P(FromZero, HardCases,
                         ::testing::Values(from_zero("mars_landing", "altro", 399.174711),
                                           from_zero("mars_landing", "proxddp", 399.174711),
                                           from_zero("mars_landing_free", "altro", 398.061102),
                                           from_zero("mars_landing_free", "proxddp", 398.061102)),
                         [](const auto& test) {
                           return test.param.name + "_" + test.param.solver;
                         });

constexpr const char* kStep = "problems/biped_step_cones.yaml";

INSTANTIATE_TEST_SUITE_P(
    Perturbed, HardCases,
    ::testing::Values(HardCase{"sled",
                               "tests/golden/hard/sled.yaml",
                               {"perturbation={guess: 0.02, seed: 3}"},
                               "ipddp",
                               4.51453061},
                      HardCase{"soles",
                               kStep,
                               {"contacts.defaults.size=[0.1, 0.05]",
                                "perturbation={initial_state: 0.03, guess: 0.03, seed: 1}"},
                               "altro",
                               4.22230548},
                      HardCase{"biped",
                               kStep,
                               {"perturbation={initial_state: 0.1, guess: 0.1, seed: 2}"},
                               "altro",
                               29.6767456,
                               1e-2}),
    [](const auto& test) { return test.param.name + "_" + test.param.solver; });

}  // namespace
}  // namespace conddp
