// Problems from the literature reach their exact or published optima.
#include <algorithm>
#include <filesystem>
#include <fstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "output/bench/best_known.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

const std::filesystem::path kCollection = source_tree() / "problems" / "collection";

/// For grids of 100 to 240 knots with constant controls, relative for costs above 1.
constexpr double kTolerance = 1e-4;

std::vector<std::string> collection() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(kCollection))
    if (entry.path().extension() == ".yaml") names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

const nlohmann::json& known_optima() {
  static const nlohmann::json known = [] {
    std::ifstream stream(kCollection / kBestKnownFile);
    return nlohmann::json::parse(stream).at("problems");
  }();
  return known;
}

class Collection : public ::testing::TestWithParam<std::string> {};

/// Uses the solver in the file, or another.
void expect_optimum(const std::string& name, const std::string& solver = "") {
  Diagnostics out;
  const auto spec = read_problem(kCollection / (name + ".yaml"), {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  EXPECT_TRUE(out.list().empty()) << format_diagnostics(out, false);
  EXPECT_EQ(spec->name.value, name);
  const SolveResult result =
      solve(*built->problem, solver.empty() ? spec->solver.name.value : solver,
            spec->solver.options, built->guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  ASSERT_TRUE(known_optima().contains(name));
  const nlohmann::json& published = known_optima()[name].at("published").at(0);
  const double optimum = published.at("cost");
  EXPECT_FALSE(published.at("source").get<std::string>().empty());
  EXPECT_NEAR(result.cost, optimum, kTolerance * std::max(1.0, std::abs(optimum)));
}

TEST_P(Collection, MeetsThePublishedOptimum) { expect_optimum(GetParam()); }

// From the guesses of the files, both solvers stall on `goddard` and end at a least violation of
// `zermelo`.
TEST_P(Collection, AltroAndProxddpMeetIt) {
  if (GetParam() == "goddard" || GetParam() == "zermelo") return;
  for (const char* solver : {"altro", "proxddp"}) {
    SCOPED_TRACE(solver);
    expect_optimum(GetParam(), solver);
  }
}

INSTANTIATE_TEST_SUITE_P(Problems, Collection, ::testing::ValuesIn(collection()),
                         [](const auto& name) { return name.param; });

}  // namespace
}  // namespace conddp
