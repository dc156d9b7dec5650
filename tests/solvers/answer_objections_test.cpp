// Continued solves after objections to a converged answer.
#include <deque>

#include <gtest/gtest.h>

#include "solvers/strategies/strategies.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// A solver with scripted costs and statuses of its answers; records its inputs.
class Script {
 public:
  struct Answer {
    double cost;
    SolveStatus status = SolveStatus::converged;
  };
  struct Call {
    SolverOptions options;
    Trajectory guess;
  };

  explicit Script(std::deque<Answer> answers) : answers_(std::move(answers)) {}

  /// A solve with these successive objections, then none.
  SolveResult run(std::deque<Objection> objections) {
    const Doubt doubt = [&](const ShootingProblem&, const SolveResult&) {
      if (objections.empty()) return Objection();
      Objection next = objections.front();
      objections.pop_front();
      return next;
    };
    return solve_answering(
        problem, options, guess, doubt, remaining,
        [&](const SolverOptions& asked, const Trajectory& start) { return answer(asked, start); });
  }

  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const SolverOptions options;
  const Trajectory guess = testing::constant_controls(problem, 0.1);
  std::vector<Call> calls;
  Objection remaining;

 private:
  SolveResult answer(const SolverOptions& asked, const Trajectory& start) {
    calls.push_back({asked, start});
    SolveResult result(problem);
    result.status = answers_.front().status;
    result.cost = answers_.front().cost;
    result.trajectory = testing::constant_controls(problem, 0.01 * result.cost);
    result.residuals = {.stationarity = 0, .gap = 0, .constraint = 0};
    result.iterations = 3;
    result.control_gradient.assign(problem.knots(), Eigen::VectorXd::Zero(2));
    answers_.pop_front();
    return result;
  }

  std::deque<Answer> answers_;
};

Objection too_much_left(double excess) { return {.text = "much is left", .excess = excess}; }

/// A descent along the first control of the first knot.
Objection a_saddle(const ShootingProblem& problem) {
  Objection objection{.text = "a saddle"};
  for (int k = 0; k <= problem.knots(); ++k)
    objection.descent.push_back(
        Eigen::VectorXd::Zero(problem.ndx() + (k < problem.knots() ? problem.nu(k) : 0)));
  objection.descent[0][problem.ndx()] = 0.2;
  return objection;
}

TEST(AnswerObjections, KeepsAnswersWithoutObjection) {
  Script script(std::deque<Script::Answer>{{1}});
  EXPECT_EQ(script.run({}).cost, 1);
  EXPECT_EQ(script.calls.size(), 1u);
}

TEST(AnswerObjections, TolerancesFallWithTheRootOfTheGain) {
  Script script({{2}, {1}});
  const SolveResult result = script.run({too_much_left(100)});
  EXPECT_EQ(result.cost, 1);
  EXPECT_EQ(result.iterations, 6);
  ASSERT_EQ(script.calls.size(), 2u);
  const auto& [options, start] = script.calls[1];
  EXPECT_DOUBLE_EQ(options.tolerances.stationarity, 0.05 * SolverOptions().tolerances.stationarity);
  EXPECT_EQ(start.u(0)[0], 0.02) << "from the answer before";
  EXPECT_NE(options.multipliers, nullptr);
  EXPECT_TRUE(script.remaining.text.empty());
}

TEST(AnswerObjections, WorseEndKeepsTheAnswer) {
  Script script({{2}, {1, SolveStatus::diverged}});
  const SolveResult result = script.run({too_much_left(100)});
  EXPECT_EQ(result.cost, 2);
  EXPECT_EQ(result.iterations, 3);
  EXPECT_EQ(script.remaining.text, "much is left");
}

TEST(AnswerObjections, ReturnsTheLastOneWithoutProgress) {
  Script script({{2}, {2}, {2}});
  script.run({too_much_left(100), too_much_left(99), too_much_left(98)});
  EXPECT_EQ(script.calls.size(), 2u);
}

TEST(AnswerObjections, LeavesASaddleInTheCheaperDirection) {
  Script up({{2}, {3}, {1}});
  const SolveResult result = up.run({a_saddle(up.problem)});
  EXPECT_EQ(result.cost, 1) << "the second way";
  ASSERT_EQ(up.calls.size(), 3u);
  EXPECT_EQ(up.calls[1].options.tolerances.stationarity, SolverOptions().tolerances.stationarity);
  Script stuck({{2}, {3}, {2}});
  EXPECT_EQ(stuck.run({a_saddle(stuck.problem)}).iterations, 3) << "the saddle itself";
  EXPECT_EQ(stuck.remaining.text, "a saddle");
}

TEST(AnswerObjections, TightensTolerancesAtSaddlesItCannotLeave) {
  Script script({{2}, {3}, {2}, {1}});
  Objection saddle = a_saddle(script.problem);
  saddle.excess = 100;
  EXPECT_EQ(script.run({saddle}).cost, 1);
  ASSERT_EQ(script.calls.size(), 4u) << "both sides, then smaller tolerances";
  EXPECT_DOUBLE_EQ(script.calls[3].options.tolerances.stationarity,
                   0.05 * SolverOptions().tolerances.stationarity);
}

TEST(AnswerObjections, LimitsIterationsForSmallGainsOnly) {
  Script small({{2}, {1}}), large({{2}, {1}});
  small.run({too_much_left(10)});
  large.run({too_much_left(1e6)});
  EXPECT_LT(small.calls[1].options.max_iterations, SolverOptions().max_iterations / 10);
  EXPECT_GT(large.calls[1].options.max_iterations, SolverOptions().max_iterations / 2);
}

}  // namespace
}  // namespace conddp
