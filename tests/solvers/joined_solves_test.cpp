#include "solvers/strategies/joined_solves.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// A solve with this many iterations from this start.
SolveResult solve_of(int iterations, const std::string& start, double seconds) {
  SolveResult result(testing::pendulum_swing_up());
  result.iterations = iterations;
  result.start = start;
  for (int i = 0; i <= iterations; ++i) result.log.push_back({.iteration = i});
  result.times.evaluate = seconds;
  result.times.differentiate = 2 * seconds;
  result.times.sweep = 3 * seconds;
  result.times.rollout = 4 * seconds;
  return result;
}

TEST(JoinedSolves, AppearAsOneSolve) {
  const SolverOptions options{.max_iterations = 20};
  JoinedSolves joined(options);
  EXPECT_EQ(joined.next().max_iterations, 20);
  joined.add(solve_of(3, "file", 0.5));
  EXPECT_EQ(joined.iterations_left(), 17);
  EXPECT_EQ(joined.next().max_iterations, 17);
  joined.add(solve_of(5, "other", 0.25));
  EXPECT_EQ(joined.iterations_left(), 12);
  SolveResult last = solve_of(5, "other", 0.25);
  last.status = SolveStatus::line_search_failed;
  const SolveResult all = joined.answer(std::move(last));
  EXPECT_EQ(all.status, SolveStatus::line_search_failed);
  EXPECT_EQ(all.iterations, 8);
  EXPECT_EQ(all.start, "file");
  EXPECT_DOUBLE_EQ(all.times.evaluate, 0.75);
  EXPECT_DOUBLE_EQ(all.times.differentiate, 1.5);
  EXPECT_DOUBLE_EQ(all.times.sweep, 2.25);
  EXPECT_DOUBLE_EQ(all.times.rollout, 3);
  ASSERT_EQ(all.log.size(), 4u + 6u);
  EXPECT_EQ(all.log[3].iteration, 3);
  EXPECT_EQ(all.log[4].iteration, 3);
  EXPECT_EQ(all.log[9].iteration, 8);
  EXPECT_GE(all.log[4].time_s, all.log[3].time_s);
}

TEST(JoinedSolves, ShareTheirTime) {
  SolverOptions options;
  options.max_time_s = 10;
  JoinedSolves solves(options);
  EXPECT_EQ(solves.next().max_time_s, 10);
  solves.add(solve_of(0, "", 0));
  const double second = solves.next().max_time_s;
  EXPECT_LT(second, 10);
  EXPECT_GT(second, 1);
  options.max_time_s = 1e-9;
  JoinedSolves late(options);
  late.add(solve_of(0, "", 0));
  EXPECT_EQ(late.next().max_time_s, 1e-3) << "what is left of none";
}

TEST(JoinedSolves, LeaveNoIterationsIfAllAreUsed) {
  const SolverOptions options{.max_iterations = 4};
  JoinedSolves joined(options);
  joined.next();
  joined.add(solve_of(6, "file", 0));
  EXPECT_EQ(joined.iterations_left(), 0);
}

TEST(JoinedSolves, ShowRowsWithTheirMark) {
  SolverOptions options{.max_iterations = 20};
  std::vector<IterationRecord> shown;
  options.on_iteration = [&](const IterationRecord& row) { shown.push_back(row); };
  JoinedSolves joined(options);
  joined.next();
  joined.add(solve_of(3, "file", 0));
  const SolverOptions own = joined.next([](IterationRecord& row) { row.cost = 42; });
  own.on_iteration({.iteration = 2, .cost = 1});
  ASSERT_EQ(shown.size(), 1u);
  EXPECT_EQ(shown[0].iteration, 5);
  EXPECT_EQ(shown[0].cost, 42);
}

TEST(JoinedSolves, RememberAnInterruption) {
  SolverOptions options;
  bool interrupted = true;
  options.interrupted = [&] { return interrupted; };
  JoinedSolves joined(options);
  EXPECT_TRUE(joined.next().interrupted());
  interrupted = false;
  EXPECT_TRUE(joined.next().interrupted());
}

TEST(NextFirstPenalty, IsGeometricMeanOfFirstAndLargestNeeded) {
  SolverOptions options;
  options.augmented_lagrangian.initial_penalty = 10;
  options.augmented_lagrangian.max_penalty = 1e3;
  SolveResult last(testing::pendulum_swing_up());
  EXPECT_EQ(next_first_penalty(options, last), 10);
  last.log.push_back({});
  last.log.back().constraint_penalty = 1000;
  EXPECT_DOUBLE_EQ(next_first_penalty(options, last), 100);
  last.log.back().constraint_penalty = 5;
  EXPECT_EQ(next_first_penalty(options, last), 10);
  last.log.back().constraint_penalty = 1e6;
  EXPECT_EQ(next_first_penalty(options, last), 1e3);
}

}  // namespace
}  // namespace conddp
