// Segment sweeps around the guess of every example problem that proxddp supports.
#include <gtest/gtest.h>

#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/foreign_problems.hpp"
#include "support/segment_comparison.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// Returns true if there was something to sweep: false if another solver or regularization is
/// needed.
bool expect_equal(const fs::path& file, const std::vector<std::string>& settings = {}) {
  Diagnostics out;
  const auto spec = read_problem(file, settings, out);
  const auto built = spec ? build_problem(*spec, {}, out) : std::nullopt;
  EXPECT_TRUE(built) << format_diagnostics(out, false);
  if (!built || unsupported(*find_solver("proxddp"), *built->problem)) return false;
  if (!testing::SegmentedIterate(*built->problem, built->guess, {}).begin()) return false;
  SCOPED_TRACE(file.stem().string());
  testing::expect_equal_by_segments(*built->problem, built->guess);
  return true;
}

TEST(SegmentSweep, MatchesSequentialSweepOnExampleProblems) {
  int swept = 0;
  for (const auto& entry : fs::directory_iterator(fs::path(CONDDP_SOURCE_DIR) / "problems"))
    if (entry.path().extension() == ".yaml") swept += expect_equal(entry.path());
  EXPECT_GE(swept, 30);
}

TEST(SegmentSweep, MatchesSequentialSweepOnForeignRobots) {
  for (const auto& foreign : {hyq_trot(), talos_squat()}) {
    if (!foreign) GTEST_SKIP() << kNoForeignRobots;
    EXPECT_TRUE(expect_equal(foreign->file, foreign->settings));
  }
}

}  // namespace
}  // namespace conddp
