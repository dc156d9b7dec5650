// problems/best_known.json, compared with its problems and their golden files. scripts/best_known
// maintains it.
#include "output/bench/best_known.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "output/solution/golden_case.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

const fs::path kTree = source_tree();

/// Hash of a problem; empty, with a test failure, if it cannot be built.
std::string hash_of(const fs::path& file, const std::vector<std::string>& settings = {}) {
  Diagnostics out;
  const auto spec = read_problem(file, settings, out);
  const auto built = spec ? build_problem(*spec, {}, out) : std::nullopt;
  EXPECT_TRUE(built) << format_diagnostics(out, false);
  return built ? problem_sha256(*built) : "";
}

BestKnown best_known() {
  Diagnostics out;
  const auto known = load_best_known(kTree / "problems" / kBestKnownFile, out);
  EXPECT_TRUE(known) << format_diagnostics(out, false);
  return known.value_or(BestKnown());
}

TEST(BestKnownOptima, EveryExampleHasAnUpToDateOptimum) {
  std::ifstream stream(kTree / "problems" / kBestKnownFile);
  const nlohmann::json entries = nlohmann::json::parse(stream).at("problems");
  std::size_t problems = 0;
  for (const auto& file : fs::directory_iterator(kTree / "problems")) {
    if (file.path().extension() != ".yaml") continue;
    ++problems;
    const std::string name = file.path().stem();
    ASSERT_TRUE(entries.contains(name)) << name << ": run scripts/best_known " << file.path();
    EXPECT_EQ(entries[name]["problem_sha256"], hash_of(file.path()))
        << name << " is another problem by now: run scripts/best_known " << file.path();
    EXPECT_NE(entries[name]["command"].get<std::string>().find("problems/" + name + ".yaml"),
              std::string::npos);
  }
  EXPECT_EQ(entries.size(), problems);
}

// An answer from the file's own guess cannot beat the best known optimum.
TEST(BestKnownOptima, NoGoldenFileIsBetter) {
  const BestKnown known = best_known();
  int compared = 0;
  for (const fs::path& folder : {kTree / "tests/golden", kTree / "tests/golden/slow"})
    for (const auto& file : fs::directory_iterator(folder)) {
      if (file.path().extension() != ".json") continue;
      Diagnostics out;
      const auto golden = load_golden(file.path(), out);
      ASSERT_TRUE(golden) << format_diagnostics(out, false);
      const auto best = known.find(hash_of(golden->problem_file, golden->overrides));
      if (best == known.end()) continue;  // covered by the other test
      const double cost = golden->answer.at("cost");
      EXPECT_GE(cost, best->second - 1e-6 * std::abs(best->second))
          << golden->name << ": run scripts/best_known " << golden->problem_file;
      ++compared;
    }
  EXPECT_GT(compared, 50);
}

}  // namespace
}  // namespace conddp
