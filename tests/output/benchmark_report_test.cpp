#include "output/bench/benchmark_report.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "base/text/text_layout.hpp"

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

TEST(BenchmarkReport, ComparesCostsWithBestOfTheProblem) {
  const BenchmarkReport r = report();
  EXPECT_EQ(r.entries[0].cost_excess, 0);
  EXPECT_EQ(r.entries[1].cost_excess, 0.25);
  EXPECT_TRUE(std::isnan(r.entries[2].cost_excess));
  EXPECT_TRUE(std::isnan(r.entries[3].cost_excess)) << "there is nothing to compare it with";
}

// Several guesses of one problem remain one problem; several initial states are several problems.
TEST(BenchmarkReport, ComparesInstancesOfTheSameProblem) {
  for (const bool moved : {false, true}) {
    BenchmarkReport r{.request = {.solvers = {"a"}, .instances = 2}};
    r.entries = {entry("first", "a", 2.0, 0.1), entry("first", "a", 3.0, 0.2)};
    for (int i = 0; i < 2; ++i) {
      r.entries[i].seed = i;
      r.entries[i].initial_state = {1, moved ? 0.1 * i : 0};
    }
    compare_costs(r);
    EXPECT_EQ(std::isnan(r.entries[0].cost_excess), moved);
    EXPECT_EQ(std::isnan(r.entries[1].cost_excess), moved);
    if (!moved) {
      EXPECT_EQ(r.entries[1].cost_excess, 0.5);
    }
  }
}

TEST(BenchmarkReport, ComparesCostsWithTheBestKnown) {
  BenchmarkReport r{.request = {.solvers = {"a", "b"}}};
  r.entries = {entry("first", "a", 2.0, 0.1), entry("first", "b", 2.5, 0.2),
               entry("second", "a", 1.0, 0.3)};
  for (BenchmarkEntry& e : r.entries) e.best_known = 2.0;
  compare_costs(r);
  EXPECT_EQ(r.entries[0].cost_excess, 0);
  EXPECT_EQ(r.entries[1].cost_excess, 0.25);
  EXPECT_EQ(r.entries[2].cost_excess, -0.5) << "though it stands alone";
  EXPECT_FALSE(beats_best_known(r.entries[0]));
  EXPECT_TRUE(beats_best_known(r.entries[2]));
  r.entries[2].command = "conddp solve second.yaml --solver a";
  for (const bool markdown : {false, true}) {
    const std::string text = benchmark_text(r, markdown);
    EXPECT_NE(text.find("a: 1 is less than the best known cost, 2\n"), std::string::npos) << text;
    EXPECT_NE(text.find("conddp solve second.yaml --solver a"), std::string::npos) << text;
  }
}

TEST(BenchmarkReport, RoundingAroundZeroOptimumIsNoExcess) {
  BenchmarkReport r{.request = {.solvers = {"a", "b", "c"}}};
  r.entries = {entry("zero", "a", 1.7e-29, 0.1), entry("zero", "b", 9.9e-31, 0.2),
               entry("zero", "c", 6.1e-14, 0.2), entry("zero", "d", 1e-6, 0.2)};
  compare_costs(r);
  for (int i = 0; i < 3; ++i) EXPECT_LT(r.entries[i].cost_excess, 1e-9) << i;
  EXPECT_EQ(r.entries[1].cost_excess, 0);
  EXPECT_NEAR(r.entries[3].cost_excess, 1e-3, 1e-12) << "relative to a cost of 1e-3";
}

TEST(BenchmarkReport, CountsAnswersByDistanceToTheBest) {
  BenchmarkReport r{.request = {.solvers = {"a", "b"}}};
  r.entries = {entry("1", "a", 2, 1),       entry("1", "b", 2 * (1 + 5e-7), 1),
               entry("2", "a", 2, 1),       entry("2", "b", 2 * (1 + 1e-4), 1),
               entry("3", "a", 2, 1),       entry("3", "b", 2 * (1 + 1e-2), 1),
               entry("4", "a", 2 * 1.2, 1), entry("4", "b", 2, 1),
               entry("5", "a", 2, 1),       entry("5", "b", 1, 1),
               entry("6", "a", 2, 1),       entry("6", "b", 1, 1)};
  r.entries[9].run.solved = false;           // and "a" alone is the best of its instance
  r.entries[11].left_out = {{"torque", 1}};  // a different problem, not solved as given
  compare_costs(r);
  const auto summary = summarize(r);
  EXPECT_EQ(summary[0].within, (std::array<int, 3>{5, 5, 5}));
  EXPECT_EQ(summary[1].within, (std::array<int, 3>{2, 3, 4}));
  const auto json = benchmark_json(r)["summary"][1]["within"];
  EXPECT_EQ(json.dump(), R"({"1e-6":2,"1e-3":3,"1e-1":4})");
  const std::string text = benchmark_text(r, false);
  EXPECT_NE(text.find("within 1e-6  within 1e-3  within 1e-1"), std::string::npos) << text;
  EXPECT_NE(text.find(" 33.3 %       50.0 %       66.7 %"), std::string::npos) << text;
}

TEST(BenchmarkReport, ExplainsHowToReproduceFailures) {
  BenchmarkReport r{.request = {.solvers = {"a"}, .instances = 3}};
  for (int i = 1; i <= 3; ++i) {
    r.entries.push_back(entry("first", "a", 2.0, 0.1));
    r.entries.back().seed = i;
    r.entries.back().run.solved = i == 1;
    r.entries.back().run.message = "no descent";
    r.entries.back().command = fmt::format("conddp solve first.yaml --seed {}", i);
  }
  const std::string text = benchmark_text(r, false);
  EXPECT_NE(text.find("  a, seed 2: no descent\n    conddp solve first.yaml --seed 2\n"),
            std::string::npos)
      << text;
  EXPECT_EQ(text.find("--seed 1"), std::string::npos) << "it was solved";
  EXPECT_EQ(text.find("--seed 3"), std::string::npos) << "one of each solver is enough to see";
}

TEST(BenchmarkReport, AnswersWithDroppedConstraintsAreNotSolved) {
  BenchmarkReport r = report();
  const auto summary = summarize(r);
  EXPECT_EQ(summary[1].runs, 2);
  EXPECT_EQ(summary[1].solved, 1);
  EXPECT_EQ(summary[1].left_out, 1);
  EXPECT_EQ(summary[1].solved_without, 1);
}

TEST(BenchmarkReport, ProfilesCountSolvesWithAllConstraints) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  const std::vector<std::vector<double>> expected = {{0.1, 0.2}, {kNone, kNone}};
  EXPECT_EQ(efforts(report(), Effort::time), expected);
  BenchmarkReport r = report();
  r.entries[0].run.sweeps = 12;
  r.entries[1].run.sweeps = 25;
  EXPECT_EQ(benchmark_json(r)["profiles"]["sweeps"].dump(),
            R"({"a":[[12.0,0.5]],"b":[[25.0,0.5]]})");
}

TEST(BenchmarkReport, SummaryCountsFailuresByTheirStatus) {
  BenchmarkReport r = report();
  r.entries.push_back(entry("third", "a", 1, 1));
  r.entries.back().run.solved = false;  // converged by its own claim
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

TEST(BenchmarkReport, TablesNameOmissionsAndFailures) {
  BenchmarkReport r = report();
  r.entries[2].run.message = "not converged after 10 iterations";
  const std::string text = benchmark_text(r, false);
  EXPECT_NE(text.find("torque (off by 0.25)"), std::string::npos) << text;
  EXPECT_NE(text.find("\n  a: not converged after 10 iterations\n"), std::string::npos) << text;
  EXPECT_NE(text.find("\nall problems\n"), std::string::npos) << text;
}

TEST(TextTable, AlignsAndOmitsEmptyColumns) {
  const TextTable table{.columns = {{"name", false}, {"nothing"}, {"n"}},
                        .rows = {{"a", "", "1"}, {"long", "", "200"}}};
  EXPECT_EQ(table.text(1), " name    n\n a       1\n long  200\n");
  EXPECT_EQ(table.markdown(), "| name | n |\n|---|---:|\n| a | 1 |\n| long | 200 |\n");
}

}  // namespace
}  // namespace conddp
