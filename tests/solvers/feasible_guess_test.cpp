// Solves from a guess that satisfies all constraints.
#include <gtest/gtest.h>

#include "solvers/strategies/strategies.hpp"
#include "support/constrained_problems.hpp"

namespace conddp {
namespace {

/// Scripted solve results from a guess of cost 4: the guess itself without iterations; otherwise
/// this violation and cost, unless the first penalty is at least `penalty`.
class Ends {
 public:
  Ends(double cost, double violation, double penalty)
      : cost_(cost), violation_(violation), penalty_(penalty) {}

  SolveResult from(double guess_violation, bool penalizes) {
    const Trajectory guess = problem_.create_trajectory();
    return solve_keeping_guess({}, guess, penalizes,
                               [&](const SolverOptions& options, const Trajectory& start) {
                                 return end(options, start, guess_violation);
                               });
  }
  int solves = 0;

 private:
  SolveResult end(const SolverOptions& options, const Trajectory& start, double guess_violation) {
    ++solves;
    SolveResult result(problem_);
    result.trajectory = start;
    const bool stays = options.augmented_lagrangian.initial_penalty >= penalty_;
    const bool at_once = options.max_iterations == 0;
    result.iterations = at_once ? 0 : 3;
    result.status = at_once ? SolveStatus::max_iterations : SolveStatus::converged;
    if (violation_ > 0 && !stays && !at_once) result.status = SolveStatus::infeasible;
    result.cost = at_once ? 4 : stays ? 3.9 : cost_;
    result.residuals = {
        .stationarity = 0, .gap = 0, .constraint = stays || at_once ? 0 : violation_};
    result.log.resize(1);
    result.log.front().cost = 4;
    result.log.front().constraint = guess_violation;
    return result;
  }

  ShootingProblem problem_ = testing::unicycle_parking(0.6);
  double cost_, violation_, penalty_;
};

TEST(FeasibleGuess, LeadsToNoWorseAnswer) {
  Ends dearer(4.7, 0, 1e4);
  const SolveResult result = dearer.from(0, true);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(result.cost, 3.9);
  EXPECT_EQ(dearer.solves, 3);
  EXPECT_EQ(result.iterations, 9);
  EXPECT_EQ(Ends(1, 0.5, 10).from(0, true).status, SolveStatus::converged) << "infeasible before";
}

TEST(FeasibleGuess, IsTheAnswerIfNothingIsBetter) {
  for (const bool penalizes : {false, true}) {
    Ends dearer(4.7, 0, 1e9);
    const SolveResult result = dearer.from(0, penalizes);
    EXPECT_EQ(result.status, SolveStatus::line_search_failed);
    EXPECT_EQ(result.cost, 4);
    EXPECT_EQ(dearer.solves, penalizes ? 4 : 2);
  }
}

TEST(FeasibleGuess, IsKeptIfIterationsRunOut) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const SolverOptions options{.max_iterations = 3};
  const SolveResult kept =
      solve_keeping_guess(options, problem.create_trajectory(), true,
                          [&](const SolverOptions& own, const Trajectory& start) {
                            SolveResult result(problem);
                            result.trajectory = start;
                            result.iterations = own.max_iterations;
                            result.status = SolveStatus::max_iterations;
                            result.cost = own.max_iterations == 0 ? 4 : 3;
                            result.residuals.gap = 0;
                            result.residuals.constraint = own.max_iterations == 0 ? 0 : 0.5;
                            result.log.resize(1);
                            result.log.front().cost = 4;
                            result.log.front().constraint = 0;
                            return result;
                          });
  EXPECT_EQ(kept.status, SolveStatus::max_iterations);
  EXPECT_EQ(kept.cost, 4);
  EXPECT_EQ(kept.iterations, 3);
}

TEST(FeasibleGuess, GivesWayToAlmostFeasibleAnswers) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const auto cost_with = [&](double violation, double multiplier) {
    return solve_keeping_guess({}, problem.create_trajectory(), false,
                               [&](const SolverOptions& own, const Trajectory& start) {
                                 const bool at_once = own.max_iterations == 0;
                                 SolveResult result(problem);
                                 result.trajectory = start;
                                 result.status = SolveStatus::max_iterations;
                                 result.cost = at_once ? 4 : 1;
                                 result.residuals.gap = 0;
                                 result.residuals.constraint = at_once ? 0 : violation;
                                 result.constraint_multipliers.setConstant(1, multiplier);
                                 result.log.resize(1);
                                 result.log.front().cost = 4;
                                 result.log.front().constraint = 0;
                                 return result;
                               })
        .cost;
  };
  EXPECT_EQ(cost_with(1e-4, 100), 1) << "closing the violation costs .01";
  EXPECT_EQ(cost_with(1e-4, 1e5), 4) << "closing the violation costs 10";
  EXPECT_EQ(cost_with(0.5, 0), 4) << "multipliers say nothing so far off";
}

TEST(FeasibleGuess, MakesNoFalseClaim) {
  for (const auto& [cost, violation, of_guess] :
       {std::array{3.9, 0.0, 0.0}, {4.7, 0.0, 1e-3}, {4.7, 0.5, 1e-3}}) {
    Ends ends(cost, violation, 1e9);
    EXPECT_EQ(ends.from(of_guess, true).cost, cost);
    EXPECT_EQ(ends.solves, 1);
  }
}

}  // namespace
}  // namespace conddp
