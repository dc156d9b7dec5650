// Problems solved along a homotopy: certified answers at the direct optimum or at another one.
#include "problem_file/assemble/homotopy.hpp"

#include <gtest/gtest.h>

#include "output/report/solution_certificate.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/foreign_problems.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

struct HomotopyCase {
  std::string name;
  std::filesystem::path file;
  std::vector<std::string> settings;
  std::string homotopy;
  std::string solver;
  double cost;
};

void expect_solved(const HomotopyCase& c) {
  std::vector<std::string> settings = c.settings;
  settings.push_back("solver.name=" + c.solver);
  settings.push_back("solver.homotopy=" + c.homotopy);
  Diagnostics out;
  const auto spec = read_problem(c.file, settings, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  SolverOptions options = spec->solver.options;
  options.homotopy = homotopy_path(*built);
  const SolverInfo& solver = *find_solver(c.solver);
  const SolveResult result = solve(*built->problem, solver, options, built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.cost, c.cost, 1e-5 * c.cost);
  EXPECT_EQ(result.homotopy.front().share, 0);
  EXPECT_EQ(result.homotopy.back().share, 1);
  int iterations = 0;
  for (const HomotopyStep& step : result.homotopy) iterations += step.iterations;
  EXPECT_EQ(result.iterations, iterations);
  // The answer refers to the problem itself.
  const OrderedJson document =
      OrderedJson::parse(solution_json({*built, solver, result, settings}).dump());
  EXPECT_TRUE(certify_solution(document, *built, false).checks.holds());
}

class HomotopyOf : public ::testing::TestWithParam<HomotopyCase> {};

TEST_P(HomotopyOf, EndsAtACertifiedAnswer) { expect_solved(GetParam()); }

std::filesystem::path example(const std::string& name) {
  return source_tree() / "problems" / (name + ".yaml");
}

constexpr const char* kWheels =
    "[{key: constraints.wheels.lower, from: -15, to: -5}, {key: constraints.wheels.upper, from: "
    "15, "
    "to: 5}]";

INSTANTIATE_TEST_SUITE_P(
    Ready, HomotopyOf,
    ::testing::Values(
        // Cost of the golden file.
        HomotopyCase{"arm_fastest",
                     example("arm_fastest"),
                     {},
                     "[{key: costs.effort.weight, from: 0.001, to: 1.0e-4}]",
                     "altro",
                     0.702336157},
        // Direct solves end in another optimum, 0.331605617.
        HomotopyCase{
            "unicycle_escape", example("unicycle_escape"), {}, kWheels, "altro", 0.33150860},
        // Better than the direct solve, 2.28890.
        HomotopyCase{"quadrotor_maze",
                     example("quadrotor_maze"),
                     {},
                     "[{key: constraints.pillars.at_least, from: 1, to: 4}]",
                     "altro",
                     1.96076975}),
    [](const auto& test) { return test.param.name; });

TEST(HomotopyOfFriction, LeadsHyqOntoASlipperyFloor) {
  const auto trot = hyq_trot();
  if (!trot) GTEST_SKIP() << kNoForeignRobots;
  std::vector<std::string> settings = trot->settings;
  settings.emplace_back(
      "constraints.grip={residual: friction_cone, contacts: all, cone: second_order}");
  for (const char* solver : {"altro", "proxddp"})
    expect_solved({"hyq_trot", trot->file, settings,
                   "[{key: contacts.defaults.friction, from: 0.7, to: 0.15}]", solver,
                   3.61995706});  // same as the direct solve
}

}  // namespace
}  // namespace conddp
