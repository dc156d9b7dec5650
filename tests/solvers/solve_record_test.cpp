#include "solvers/common/solve_record.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "support/small_problems.hpp"

namespace conddp::testing {
namespace {

struct Recorded {
  explicit Recorded(SolverOptions given = {}, bool constrained = false)
      : problem(pendulum_swing_up()),
        options(std::move(given)),
        record(problem, options, constrained) {
    record.begin();
  }
  ShootingProblem problem;
  SolverOptions options;
  SolveRecord record;
};

TEST(SolveRecord, ReportsResidualsWithTheirKnots) {
  for (const bool constrained : {false, true}) {
    Recorded at({}, constrained);
    IterationRecord& row = at.record.row;
    row.stationarity = 1.3e-3;
    row.stationarity_knot = 4;
    row.constraint = 2e-2;
    row.constraint_knot = 7;
    row.complementarity = 3e-5;
    EXPECT_EQ(at.record.residual_text(),
              constrained ? "stationarity 1.3e-03 (knot 4), gap 0.0e+00, constraint violation "
                            "2.0e-02 (knot 7), complementarity 3.0e-05"
                          : "stationarity 1.3e-03 (knot 4), gap 0.0e+00, constraint violation "
                            "2.0e-02");
    row.gap = 5;
    row.gap_knot = 0;
    EXPECT_NE(at.record.residual_text().find(", gap 5.0e+00 (knot 0),"), std::string::npos);
  }
}

TEST(SolveRecord, LogsRowsWithTimeAndShowsThem) {
  std::vector<IterationRecord> shown;
  SolverOptions options;
  options.on_iteration = [&](const IterationRecord& row) { shown.push_back(row); };
  Recorded at(options);
  at.record.log_is_stale = true;
  for (int i = 0; i < 3; ++i) {
    at.record.row.iteration = i;
    at.record.row.cost = 10.0 - i;
    at.record.log_row();
  }
  EXPECT_FALSE(at.record.log_is_stale);
  const auto& log = at.record.result.log;
  ASSERT_EQ(log.size(), 3u);
  ASSERT_EQ(shown.size(), 3u);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(log[i].iteration, i);
    EXPECT_EQ(log[i].cost, 10 - i);
    EXPECT_EQ(shown[i].cost, 10 - i);
    EXPECT_EQ(shown[i].time_s, log[i].time_s);
    EXPECT_GE(log[i].time_s, i == 0 ? 0 : log[i - 1].time_s);
  }
  EXPECT_GT(log[2].time_s, 0);
  const SolveResult& result = at.record.finished();
  EXPECT_EQ(result.iterations, 2);
  EXPECT_GE(result.times.total, log.empty() ? shown[2].time_s : log[2].time_s);
  EXPECT_EQ(result.log.size(), 3u);
}

TEST(SolveRecord, BeginForgetsThePreviousSolve) {
  Recorded at;
  at.record.row.iteration = 5;
  at.record.log_row();
  at.record.log_is_stale = true;
  at.record.result.failed_knot = 3;
  at.record.end(SolveStatus::converged, "done");
  at.record.begin();
  EXPECT_EQ(at.record.row.iteration, 0);
  EXPECT_TRUE(at.record.result.log.empty());
  EXPECT_FALSE(at.record.log_is_stale);
  EXPECT_EQ(at.record.result.failed_knot, -1);
  EXPECT_EQ(at.record.result.status, SolveStatus::diverged);
  EXPECT_EQ(at.record.result.message, "");
}

TEST(SolveRecord, EndSetsStatusAndMessageAndReturnsFalse) {
  Recorded at;
  EXPECT_FALSE(at.record.end(SolveStatus::infeasible, "no way"));
  EXPECT_EQ(at.record.result.status, SolveStatus::infeasible);
  EXPECT_EQ(at.record.result.message, "no way");
}

TEST(SolveRecord, GradientsMatchControlSizesOfKnots) {
  const ShootingProblem problem = landing();
  const SolverOptions options;
  SolveRecord record(problem, options, false);
  for (int solve = 0; solve < 2; ++solve) {
    record.begin();
    const std::vector<Eigen::VectorXd>& gradient = record.control_gradient();
    ASSERT_EQ(static_cast<int>(gradient.size()), problem.knots());
    for (int k = 0; k < problem.knots(); ++k) EXPECT_EQ(gradient[k].size(), problem.nu(k)) << k;
  }
}

TEST(SolveRecord, ContinuesUntilItsLimits) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const struct {
    int iteration, most;
    double seconds;
    bool signal, left, continues;
    SolveStatus status;
    const char* message;
  } cases[] = {
      {2, 3, kNever, false, true, true, SolveStatus::diverged, ""},
      {3, 3, kNever, false, true, false, SolveStatus::max_iterations,
       "not converged after 3 iterations: stationarity"},
      {2, 3, 0, false, false, false, SolveStatus::time_limit, "the time is up: stationarity"},
      {2, 3, 1000, false, true, true, SolveStatus::diverged, ""},
      {2, 3, kNever, true, false, false, SolveStatus::interrupted, "interrupted: stationarity"},
      {3, 3, 0, true, false, false, SolveStatus::max_iterations, "not converged after 3"},
  };
  for (const auto& c : cases) {
    SolverOptions options;
    options.max_iterations = c.most;
    options.max_time_s = c.seconds;
    options.interrupted = [&] { return c.signal; };
    Recorded at(options);
    at.record.row.iteration = c.iteration;
    EXPECT_EQ(at.record.budget_left(), c.left) << c.message;
    EXPECT_EQ(at.record.may_continue(), c.continues) << c.message;
    EXPECT_EQ(at.record.result.status, c.status) << c.message;
    EXPECT_EQ(at.record.result.message.rfind(c.message, 0), 0u) << at.record.result.message;
  }
}

}  // namespace
}  // namespace conddp::testing
