#include "output/benchmark_report.hpp"

#include <gtest/gtest.h>

#include "output/text_table.hpp"

namespace conddp {
namespace {

BenchmarkEntry entry(const std::string& problem, const std::string& solver, double cost,
                     double time_s) {
  BenchmarkEntry e{.problem = problem, .file = problem + ".yaml", .knots = 2, .states = 3};
  e.run.solver = solver;
  e.run.status = "converged";
  e.run.solved = true;
  e.run.iterations = 10;
  e.run.check.cost = cost;
  e.run.median.total = time_s;
  e.run.times = {time_s};
  return e;
}

BenchmarkReport report() {
  BenchmarkReport r{.request = {.solvers = {"a", "b"}}};
  r.entries = {entry("first", "a", 2.0, 0.1), entry("first", "b", 2.5, 0.2),
               entry("second", "a", 1.0, 0.3), entry("second", "b", 0.5, 0.1)};
  r.entries[2].run.status = "max_iterations";
  r.entries[2].run.solved = false;
  r.entries[3].left_out = {{"torque", 0.25}};
  compare_costs(r);
  return r;
}

TEST(BenchmarkReport, CostsAreComparedWithTheBestOfTheSameProblem) {
  const BenchmarkReport r = report();
  EXPECT_EQ(r.entries[0].cost_excess, 0);
  EXPECT_EQ(r.entries[1].cost_excess, 0.25);
  EXPECT_TRUE(std::isnan(r.entries[2].cost_excess));
  EXPECT_TRUE(std::isnan(r.entries[3].cost_excess)) << "there is nothing to compare it with";
}

// One problem from several guesses is one problem; from several initial states it is several.
TEST(BenchmarkReport, InstancesAreComparedWithEachOtherWhereTheyAreTheSameProblem) {
  for (const bool moved : {false, true}) {
    BenchmarkReport r{.request = {.solvers = {"a"}, .instances = 2}};
    if (moved) r.request.initial_state_size = 0.1;
    r.entries = {entry("first", "a", 2.0, 0.1), entry("first", "a", 3.0, 0.2)};
    for (int i = 0; i < 2; ++i) r.entries[i].seed = i;
    compare_costs(r);
    EXPECT_EQ(std::isnan(r.entries[0].cost_excess), moved);
    EXPECT_EQ(std::isnan(r.entries[1].cost_excess), moved);
    if (!moved) {
      EXPECT_EQ(r.entries[1].cost_excess, 0.5);
    }
  }
}

TEST(BenchmarkReport, WhatLacksAConstraintIsNotCountedAsSolved) {
  BenchmarkReport r = report();
  const auto summary = summarize(r);
  EXPECT_EQ(summary[1].runs, 2);
  EXPECT_EQ(summary[1].solved, 1);
  EXPECT_EQ(summary[1].left_out, 1);
  EXPECT_EQ(summary[1].solved_without, 1);
}

TEST(BenchmarkReport, ProfilesCountWhatWasSolvedWithAllConstraints) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> expected = {{0.1, 0.2}, {kNone, kNone}};
  EXPECT_EQ(efforts(report(), Effort::time), expected);
}

TEST(BenchmarkReport, SummaryCountsFailuresByTheirStatus) {
  BenchmarkReport r = report();
  r.entries.push_back(entry("third", "a", 1, 1));
  r.entries.back().run.solved = false;  // converged, as it says
  r.entries.push_back(entry("third", "b", 1, 1));
  r.entries.back().run.status = "refused";
  EXPECT_TRUE(all_kept_word(report()));
  EXPECT_FALSE(all_kept_word(r));
  const auto summary = summarize(r);
  ASSERT_EQ(summary.size(), 2u);
  EXPECT_EQ(summary[0].runs, 3);
  EXPECT_EQ(summary[0].solved, 1);
  EXPECT_EQ(summary[0].failures,
            (std::vector<std::pair<std::string, int>>{{"check failed", 1}, {"max_iterations", 1}}));
  EXPECT_EQ(summary[1].runs, 2);
  EXPECT_EQ(summary[1].left_out, 1);
  EXPECT_EQ(summary[1].refused, 1);
}

TEST(BenchmarkReport, TablesNameWhatWasLeftOutAndWhatFailed) {
  BenchmarkReport r = report();
  r.entries[2].run.message = "not converged after 10 iterations";
  const std::string text = benchmark_text(r, false);
  EXPECT_NE(text.find("torque (off by 0.25)"), std::string::npos) << text;
  EXPECT_NE(text.find("\n  a: not converged after 10 iterations\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nall problems\n"), std::string::npos) << text;
}

TEST(TextTable, AlignsAndLeavesEmptyColumnsOut) {
  const TextTable table{.columns = {{"name", false}, {"nothing"}, {"n"}},
                        .rows = {{"a", "", "1"}, {"long", "", "200"}}};
  EXPECT_EQ(table.text(1), " name    n\n a       1\n long  200\n");
  EXPECT_EQ(table.markdown(), "| name | n |\n|---|---:|\n| a | 1 |\n| long | 200 |\n");
}

}  // namespace
}  // namespace conddp
