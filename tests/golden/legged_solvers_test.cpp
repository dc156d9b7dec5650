// Every legged problem with soft constraints from the quasi-static guess: box_fddp within torque
// limits, fddp without them. Airborne motions start from keyframes that violate the dynamics.
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

const fs::path kReadyProblems = source_tree() / "problems";

std::vector<std::string> legged_problems() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(kReadyProblems)) {
    if (entry.path().extension() != ".yaml") continue;
    Diagnostics out;
    const auto spec = read_problem(entry.path(), {}, out);
    if (spec && !spec->contacts.empty() && spec->constraints.empty())
      names.push_back(entry.path().stem().string());
  }
  std::sort(names.begin(), names.end());
  return names;
}

void expect_solved(const std::string& name, const std::string& solver, const std::string& guess) {
  SCOPED_TRACE(name + " by " + solver);
  Diagnostics out;
  const auto spec = read_problem(kReadyProblems / (name + ".yaml"),
                                 {"initial_guess=" + guess, "solver.name=" + solver}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const bool bounded = solver == "box_fddp";
  const auto built =
      build_problem(*spec, {.drop = std::vector<std::string>(bounded ? 0 : 1, "torque")}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  const SolveResult result = solve(*built->problem, solver, spec->solver.options, built->guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_LE(result.residuals.gap, 1e-9);
  EXPECT_LE(result.residuals.constraint, 0);
}

class LeggedProblem : public ::testing::TestWithParam<std::string> {};

TEST_P(LeggedProblem, IsSolvedFromTheQuasiStaticGuess) {
  for (const char* solver : {"box_fddp", "fddp"})
    expect_solved(GetParam(), solver, "{states: initial, controls: quasi_static}");
}

INSTANTIATE_TEST_SUITE_P(Ready, LeggedProblem, ::testing::ValuesIn(legged_problems()),
                         [](const auto& name) { return name.param; });

TEST(LeggedMotion, IsSolvedFromInconsistentKeyframes) {
  const std::pair<const char*, const char*> guesses[] = {
      {"quadruped_jump",
       "[{time: 0.4, state: standing}, {time: 0.55, state: leap}, {time: 0.7, state: "
       "{configuration: "
       "standing, displaced: [0.4, 0, 0]}}]"},
      {"hopper_jump", "[{time: 0.45, state: standing}, {time: 0.77, state: landed}]"},
      {"biped_steps",
       "[{time: 0.4, state: on_right}, {time: 1.1, state: on_left}, {time: 2.2, state: arrived}]"}};
  for (const auto& [name, keyframes] : guesses)
    for (const char* solver : {"box_fddp", "fddp"})
      expect_solved(
          name, solver,
          "{states: {keyframes: " + std::string(keyframes) + "}, controls: quasi_static}");
}

}  // namespace
}  // namespace conddp
