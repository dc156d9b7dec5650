// Path of a homotopy: problems solved and iterations counted.
#include <gtest/gtest.h>

#include "solvers/strategies/strategies.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// A scripted solver: solves the problem at a share if it lies within `reach` of the last answer,
/// in a given number of iterations.
struct Rule {
  double reach = 1;     ///< a longer step fails
  int iterations = 10;  ///< of a successful solve
  int failing = 10;     ///< of a failed solve
};

/// Problem at a share, which is stored in its initial state and in the answer's place.
std::shared_ptr<const ShootingProblem> at(double share) {
  const testing::TrackingCost cost{.goal = {1, 0}, .q = {1, 1}, .r = {1}, .qf = {1, 1}};
  return std::make_shared<ShootingProblem>(testing::tracking_problem(
      double_integrator(1), Integrator::semi_implicit_euler, 3, 0.1, {share, 0}, cost));
}

struct Journey {
  explicit Journey(Rule with) : rule(with) {
    options.homotopy = [this](double share) { return share == hole ? nullptr : at(share); };
  }

  SolveResult go() {
    const auto end = at(1);
    const SolveByFirst solve = [&](const ShootingProblem& problem, SolverList,
                                   const SolverOptions& own, const Trajectory& guess,
                                   const SolverInfo*& used) {
      used = find_solver("altro");
      const double share = problem.initial_state()[0];
      const bool good =
          (direct_fails ? share < 1 : true) && share - guess.x(0)[0] <= rule.reach * (1 + 1e-12);
      SolveResult result(problem);
      const int wanted = good ? rule.iterations : rule.failing;
      result.iterations = std::min(wanted, own.max_iterations);
      result.status = wanted > own.max_iterations ? SolveStatus::max_iterations
                      : good                      ? SolveStatus::converged
                                                  : SolveStatus::line_search_failed;
      if (own.interrupted && own.interrupted()) result.status = SolveStatus::interrupted;
      for (int i = 0; i <= result.iterations; ++i) {
        result.log.push_back({.iteration = i});
        if (own.on_iteration) own.on_iteration(result.log.back());
      }
      had_multipliers.push_back(own.multipliers != nullptr);
      return result;
    };
    const SolverInfo* used = nullptr;
    const std::vector<const SolverInfo*> candidates{find_solver("altro")};
    return solve_homotopy(*end, candidates, options, at(0)->create_trajectory(), solve, used);
  }

  Rule rule;
  SolverOptions options;
  bool direct_fails = false;
  double hole = -1;
  std::vector<bool> had_multipliers;
};

std::vector<double> shares(const SolveResult& result) {
  std::vector<double> list;
  for (const HomotopyStep& step : result.homotopy) list.push_back(step.share);
  return list;
}

using Shares = std::vector<double>;

TEST(Homotopy, DoublesStepsAfterQuickSolves) {
  Journey journey({.reach = 1});
  const SolveResult result = journey.go();
  EXPECT_EQ(shares(result), (Shares{0, 0.25, 0.75, 1}));
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(result.iterations, 40);
  EXPECT_EQ(journey.had_multipliers, (std::vector<bool>{false, true, true, true}));
}

TEST(Homotopy, HalvesStepsAfterFailures) {
  Journey journey({.reach = 0.3});
  EXPECT_EQ(shares(journey.go()), (Shares{0, 0.25, 0.75, 0.5, 1, 0.75, 1}));
}

TEST(Homotopy, AvoidsProblemsThatCannotBeBuilt) {
  Journey journey({.reach = 1});
  journey.hole = 0.25;
  const SolveResult result = journey.go();
  EXPECT_EQ(shares(result), (Shares{0, 0.25, 0.125, 0.375, 0.875, 1}));
  EXPECT_EQ(result.homotopy[1].status, SolveStatus::infeasible);
  EXPECT_EQ(result.status, SolveStatus::converged);
}

TEST(Homotopy, LogsAllSolvesAsOne) {
  Journey journey({.reach = 0.3});
  std::vector<IterationRecord> told;
  journey.options.on_iteration = [&](const IterationRecord& row) { told.push_back(row); };
  const SolveResult result = journey.go();
  ASSERT_EQ(told.size(), result.log.size());
  EXPECT_EQ(result.log.front().iteration, 0);
  EXPECT_EQ(result.log.back().iteration, result.iterations);
  EXPECT_EQ(result.log.back().homotopy, 1);
  for (std::size_t i = 1; i < told.size(); ++i) {
    EXPECT_GE(result.log[i].iteration, result.log[i - 1].iteration);
    EXPECT_EQ(told[i].iteration, result.log[i].iteration);
    EXPECT_EQ(told[i].homotopy, result.log[i].homotopy);
  }
}

TEST(Homotopy, ReportsWhereItStallsAndTriesTheTarget) {
  Journey journey({.reach = 1e-3});
  journey.direct_fails = true;
  const SolveResult result = journey.go();
  EXPECT_EQ(result.status, SolveStatus::line_search_failed);
  EXPECT_TRUE(result.message.starts_with(
      "homotopy stuck at s = 0: the step to 0.001953 ended as line_search_failed; from there"))
      << result.message;
  EXPECT_EQ(result.homotopy.back().share, 1);
  EXPECT_EQ(result.trajectory.x(0)[0], 1) << "the shape of the problem itself";
}

// `max_iterations` limits all solves together; ending at this limit means that they are used up.
TEST(Homotopy, SpendsOnlyTheAllowedIterations) {
  for (const int most : {0, 1, 7, 40, 300}) {
    Journey journey({.reach = 0.01, .iterations = 10, .failing = 1000});
    journey.options.max_iterations = most;
    const SolveResult result = journey.go();
    EXPECT_EQ(result.iterations, most);
    EXPECT_EQ(result.status, SolveStatus::max_iterations);
    const HomotopyStep& first = result.homotopy[0];
    EXPECT_EQ(first.status == SolveStatus::converged, most > 20) << "the first may take half";
    EXPECT_TRUE(most < 100 || result.homotopy[1].iterations == 50) << "a step takes not all";
  }
}

TEST(Homotopy, EndsOnASignal) {
  Journey journey({.reach = 1});
  int asked = 0;
  journey.options.interrupted = [&] { return ++asked == 2; };  // once: it must be remembered
  const SolveResult result = journey.go();
  EXPECT_EQ(result.status, SolveStatus::interrupted);
  EXPECT_EQ(shares(result), (Shares{0, 0.25, 1}));
}

// Through the registry with real solvers: the limit of a pendulum motor decreases.
TEST(Homotopy, EndsAtTheOptimumOfTheProblem) {
  const double weak = 3, strong = 12;
  const ShootingProblem problem = testing::pendulum_swing_up(weak);
  SolverOptions options;
  options.homotopy = [&](double share) {
    return std::make_shared<const ShootingProblem>(
        testing::pendulum_swing_up(strong + share * (weak - strong)));
  };
  for (const char* solver : {"box_fddp", "altro", "proxddp", "ipopt", "auto"}) {
    const SolveResult result = solve(problem, solver, options, problem.create_trajectory());
    EXPECT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_GE(result.homotopy.size(), 2u) << solver;
    EXPECT_EQ(result.homotopy.back().share, 1) << solver;
    // A solve from the answer without the homotopy has nothing to do.
    const SolveResult again = solve(problem, "box_fddp", {}, result.trajectory);
    EXPECT_EQ(again.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(again.cost, result.cost, 1e-8 * result.cost) << solver;
    EXPECT_LE(again.iterations, 3) << solver;
  }
}

}  // namespace
}  // namespace conddp
