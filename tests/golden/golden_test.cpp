// Every example problem, compared with its known answer. 'conddp regress tests/golden --bless'
// shows differences and rewrites the answers; --add creates the answer of a new problem.
#include <algorithm>
#include <filesystem>

#include <gtest/gtest.h>

#include "support/known_answer.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

const fs::path kProblems = source_tree() / "problems";
const fs::path kGolden = source_tree() / "tests/golden";

std::vector<std::string> names_in(const fs::path& folder, const std::string& suffix) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == suffix) names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

nlohmann::json solve_ready_problem(const std::string& name) {
  return testing::solve_again(new_golden(kProblems / (name + ".yaml"), kGolden));
}

class KnownAnswer : public ::testing::TestWithParam<std::string> {};

TEST_P(KnownAnswer, IsFoundAgain) {
  testing::expect_known_answer(kGolden / (GetParam() + ".json"));
}

INSTANTIATE_TEST_SUITE_P(Golden, KnownAnswer, ::testing::ValuesIn(names_in(kGolden, ".json")),
                         [](const auto& name) { return name.param; });

TEST(Golden, EveryExampleHasItsAnswer) {
  std::vector<std::string> answered;
  for (const fs::path& folder : {kGolden, kGolden / "slow"})
    for (const std::string& name : names_in(folder, ".json")) {
      answered.push_back(name);
      Diagnostics diagnostics;
      const auto golden = load_golden(folder / (name + ".json"), diagnostics);
      ASSERT_TRUE(golden) << format_diagnostics(diagnostics, false);
      EXPECT_EQ(golden->problem_file.stem(), name);
    }
  std::sort(answered.begin(), answered.end());
  EXPECT_EQ(names_in(kProblems, ".yaml"), answered);
}

TEST(Golden, ClosedFormCartpoleMatchesItsUrdf) {
  nlohmann::json urdf = golden_part(solve_ready_problem("cartpole_swingup"));
  const nlohmann::json closed = golden_part(solve_ready_problem("cartpole_swingup_closed_form"));
  urdf["trajectory"]["columns"] = closed["trajectory"]["columns"];
  for (const Difference& d : compare_solutions(closed, urdf))
    ADD_FAILURE() << d.quantity << ": " << d.message;
}

}  // namespace
}  // namespace conddp
