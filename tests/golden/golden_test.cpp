// Every ready problem against its known answer. CONDDP_BLESS=1 in the environment rewrites the
// answers instead; look at the difference before it is committed.
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "analysis/solution_comparison.hpp"
#include "output/solution_json.hpp"
#include "problem_file/build.hpp"
#include "problem_file/read_problem.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> problem_names() {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(fs::path(CONDDP_SOURCE_DIR) / "problems"))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

nlohmann::json solve_ready_problem(const std::string& name) {
  Diagnostics diagnostics;
  const fs::path file = fs::path(CONDDP_SOURCE_DIR) / "problems" / (name + ".yaml");
  const auto spec = read_problem(file, {}, diagnostics);
  EXPECT_TRUE(spec) << file;
  const auto built = build_problem(*spec, {}, diagnostics);
  EXPECT_TRUE(built) << file;
  const SolverInfo& solver = *find_solver(spec->solver.name.value);
  const SolveResult result = solve(*built->problem, solver, spec->solver.options, built->guess);
  const auto document = solution_json(Solution{*spec, *built, solver, result, {}});
  return nlohmann::json::parse(document.dump());
}

class ReadyProblem : public testing::TestWithParam<std::string> {};

TEST_P(ReadyProblem, HasItsKnownAnswer) {
  const fs::path file = fs::path(CONDDP_SOURCE_DIR) / "tests/golden" / (GetParam() + ".json");
  const nlohmann::json actual = solve_ready_problem(GetParam());
  if (std::getenv("CONDDP_BLESS") != nullptr) {
    std::ofstream(file) << golden_part(actual).dump() << '\n';
    return;
  }
  std::ifstream stream(file);
  ASSERT_TRUE(stream) << file << " is missing; see the head of this test";
  EXPECT_EQ(actual.at("status"), "converged") << actual.at("message");
  for (const Difference& d : compare_solutions(nlohmann::json::parse(stream), actual))
    ADD_FAILURE() << GetParam() << ": " << d.quantity << ": " << d.message;
}

INSTANTIATE_TEST_SUITE_P(Golden, ReadyProblem, testing::ValuesIn(problem_names()),
                         [](const auto& name) { return name.param; });

TEST(Golden, EveryAnswerHasItsProblem) {
  const auto names = problem_names();
  for (const auto& entry : fs::directory_iterator(fs::path(CONDDP_SOURCE_DIR) / "tests/golden"))
    if (entry.path().extension() == ".json") {
      EXPECT_TRUE(std::count(names.begin(), names.end(), entry.path().stem().string()))
          << entry.path();
    }
}

TEST(Golden, TheClosedFormCartpoleAndItsUrdfHaveTheSameAnswer) {
  nlohmann::json urdf = golden_part(solve_ready_problem("cartpole_swingup"));
  const nlohmann::json closed = golden_part(solve_ready_problem("cartpole_swingup_closed_form"));
  urdf["trajectory"]["columns"] = closed["trajectory"]["columns"];
  for (const Difference& d : compare_solutions(closed, urdf))
    ADD_FAILURE() << d.quantity << ": " << d.message;
}

}  // namespace
}  // namespace conddp
