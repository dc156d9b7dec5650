#include <array>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

using Names = std::vector<std::string>;

Names names_of(const std::vector<const SolverInfo*>& list) {
  Names names;
  for (const SolverInfo* info : list) names.emplace_back(info->name);
  return names;
}

TEST(AutoSolver, DependsOnProblemAndOptions) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -1, 1);
  const ShootingProblem constrained = testing::with_constraints(*lq.problem, testing::cuts(lq));
  EXPECT_EQ(names_of(auto_solvers(*lq.problem, {})), (Names{"box_fddp", "ipopt"}));
  EXPECT_EQ(names_of(auto_solvers(constrained, {})), (Names{"altro", "proxddp", "ipopt"}));
  const SolveResult by_name = solve(constrained, "auto", {}, constrained.create_trajectory());
  const SolveResult altro = solve(constrained, "altro", {}, constrained.create_trajectory());
  EXPECT_EQ(by_name.status, SolveStatus::converged);
  EXPECT_EQ(by_name.cost, altro.cost);
}

TEST(AutoSolver, ExplainsItsOrderOfSolvers) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -1, 1);
  const ShootingProblem constrained = testing::with_constraints(*lq.problem, testing::cuts(lq));
  EXPECT_EQ(describe_auto(*lq.problem, auto_solvers(*lq.problem, {})),
            "box_fddp, since there are no constraints besides bounds on the control; then ipopt");
  EXPECT_EQ(
      describe_auto(constrained, auto_solvers(constrained, {})),
      "altro, since there are constraints besides bounds on the control; then proxddp, ipopt");
}

/// A solver that makes no progress.
SolverInfo failing() {
  return {.name = "failing",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .run = [](const ShootingProblem& problem, const SolverOptions& options,
                    const Trajectory& guess) {
            SolveResult result(problem);
            result.status = options.max_iterations > 1 ? SolveStatus::line_search_failed
                                                       : SolveStatus::max_iterations;
            result.iterations = 7;
            result.trajectory = guess;
            return result;
          }};
}

TEST(AutoSolver, TriesTheNextSolverWithoutConvergence) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolverInfo first = failing(), *box = find_solver("box_ddp");
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&first, box};
  const SolveResult result = solve(problem, both, {}, guess, used);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(used, box);
  EXPECT_TRUE(
      result.message.starts_with("failing ended as line_search_failed after 7 iterations; "))
      << result.message;
  // A user limit is not a failure of the solver.
  const SolveResult limited = solve(problem, both, {.max_iterations = 1}, guess, used);
  EXPECT_EQ(limited.status, SolveStatus::max_iterations);
  EXPECT_EQ(used, &first);
}

/// A solver that does not converge within the default limit.
SolverInfo endless(double stationarity) {
  return {.name = "endless",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .run = [stationarity](const ShootingProblem& problem, const SolverOptions&,
                                const Trajectory& guess) {
            SolveResult result(problem);
            result.status = SolveStatus::max_iterations;
            result.iterations = 1000;
            result.residuals.stationarity = stationarity;
            result.trajectory = guess;
            return result;
          }};
}

TEST(AutoSolver, DefaultIterationLimitAppliesPerSolver) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolverInfo first = endless(1), *box = find_solver("box_ddp");
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&first, box};
  EXPECT_EQ(solve(problem, both, {}, guess, used).status, SolveStatus::converged);
  EXPECT_EQ(used, box);
  EXPECT_EQ(solve(problem, both, {.max_iterations = 999}, guess, used).status,
            SolveStatus::max_iterations);
  EXPECT_EQ(used, &first);
}

TEST(AutoSolver, ReturnsSecondAnswerIfFirstDiverged) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const SolverInfo far = endless(1e20), near = endless(1);
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&far, &near};
  const SolveResult result = solve(problem, both, {}, problem.create_trajectory(), used);
  EXPECT_EQ(used, &near);
  EXPECT_EQ(result.residuals.stationarity, 1);
  EXPECT_TRUE(result.message.starts_with("endless ended as diverged after 1000 iterations; "))
      << result.message;
}

TEST(AutoSolver, ReturnsTheFirstAnswerWithoutConvergence) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -1, 1);
  // A goal that bounded controls cannot reach.
  const ShootingProblem problem = testing::with_constraints(
      *lq.problem, {testing::goal_constraint(*lq.problem, {100, 100, 100, 100})});
  const Trajectory guess = problem.create_trajectory();
  const SolveResult altro = solve(problem, "altro", {}, guess);
  ASSERT_EQ(altro.status, SolveStatus::infeasible);
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{find_solver("altro"), find_solver("proxddp")};
  const SolveResult result = solve(problem, both, {}, guess, used);
  EXPECT_EQ(result.status, SolveStatus::infeasible);
  EXPECT_EQ(used, both[0]);
  EXPECT_EQ(result.cost, altro.cost);
  EXPECT_NE(result.message.find("; proxddp ended as infeasible after "), std::string::npos)
      << result.message;
  ASSERT_TRUE(result.restarts);
  EXPECT_EQ(result.restarts->starts, 5) << "all of them end at the same violation";
}

TEST(AutoSolver, ReturnsALaterLeastViolation) {
  const testing::LinearQuadratic lq(1, 4, {3, 2}, 8, -1, 1);
  const ShootingProblem problem = testing::with_constraints(
      *lq.problem, {testing::goal_constraint(*lq.problem, {100, 100, 100, 100})});
  const SolverInfo first = failing();
  const SolverInfo* used = nullptr;
  const std::vector<const SolverInfo*> both{&first, find_solver("altro")};
  const SolveResult result = solve(problem, both, {}, problem.create_trajectory(), used);
  EXPECT_EQ(result.status, SolveStatus::infeasible);
  EXPECT_EQ(used, both[1]);
  EXPECT_TRUE(result.message.starts_with("failing ended as line_search_failed after "))
      << result.message;
}

TEST(AutoSolver, ContinuesAfterADoubtfulAnswer) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolverInfo *first = find_solver("box_fddp"), *second = find_solver("box_ddp"), *used;
  const std::vector<const SolverInfo*> both{first, second};
  int asked = 0, least = 2;
  const Doubt doubt = [&](const ShootingProblem& of, const SolveResult& answer) {
    EXPECT_EQ(&of, &problem);
    EXPECT_EQ(answer.status, SolveStatus::converged);
    return Objection{++asked < least ? "it is doubted" : ""};
  };
  const SolveResult sure = solve(problem, both, {}, guess, used, doubt);
  EXPECT_EQ(sure.status, SolveStatus::converged);
  EXPECT_EQ(used, second);
  EXPECT_NE(sure.message.find("box_fddp converged after "), std::string::npos) << sure.message;
  EXPECT_NE(sure.message.find(" iterations, but it is doubted; "), std::string::npos);
  least = 100;
  const SolveResult doubted = solve(problem, both, {}, guess, used, doubt);
  EXPECT_EQ(doubted.status, SolveStatus::converged);
  EXPECT_EQ(used, first);
  EXPECT_EQ(doubted.restarts, std::nullopt);
}

TEST(AutoSolver, EndsIfTheProblemCausesTheDoubt) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const std::vector<const SolverInfo*> both{find_solver("box_fddp"), find_solver("box_ddp")};
  const SolverInfo* used;
  int asked = 0;
  const Doubt doubt = [&](const ShootingProblem&, const SolveResult&) {
    ++asked;
    return Objection{.text = "rows repeat others", .of_problem = true, .excess = 10};
  };
  const SolveResult result =
      solve(problem, both, {}, testing::constant_controls(problem, 0.01), used, doubt);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(used, both[0]);
  EXPECT_EQ(result.attempts.size(), 1u);
  EXPECT_EQ(asked, 1) << "smaller tolerances help as little as other solvers";
}

/// A solver that converges from its nth call on, for `more` further calls.
SolverInfo converging_at(int n, std::vector<Trajectory>& guesses, int more = 0) {
  return {.name = "lucky",
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .run = [n, more, &guesses](const ShootingProblem& problem, const SolverOptions& options,
                                     const Trajectory& guess) {
            guesses.push_back(guess);
            SolveResult result = failing().run(problem, options, guess);
            const int calls = static_cast<int>(guesses.size());
            if (calls >= n && calls <= n + more) result.status = SolveStatus::converged;
            return result;
          }};
}

TEST(AutoSolver, RestartsIfAllSolversFail) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  std::vector<Trajectory> guesses, again;
  const SolverInfo lucky = converging_at(4, guesses), other = failing(), *used = nullptr;
  const std::vector<const SolverInfo*> both{&lucky, &other};
  const SolveResult result = solve(problem, both, {}, guess, used);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_EQ(used, &lucky);
  ASSERT_TRUE(result.restarts);
  EXPECT_EQ(result.restarts->starts, 4);
  EXPECT_EQ(result.restarts->converged, 1);
  EXPECT_EQ(result.restarts->answer, 3);
  ASSERT_EQ(result.restarts->basins.size(), 1u);
  EXPECT_NE(result.message.find("lucky from restart 3 of at most 20"), std::string::npos)
      << result.message;
  ASSERT_EQ(guesses.size(), 4u);
  EXPECT_EQ(guesses[0].u(0), guess.u(0));
  EXPECT_GT((guesses[1].u(0) - guess.u(0)).norm(), 0.1);
  EXPECT_NE(guesses[2].u(0), guesses[1].u(0));
  const SolverInfo same = converging_at(4, again);
  const std::vector<const SolverInfo*> repeated{&same, &other};
  solve(problem, repeated, {}, guess, used);
  ASSERT_EQ(again.size(), 4u);
  EXPECT_EQ(again[3].x(1), guesses[3].x(1)) << "by the seed";
}

TEST(AutoSolver, RestartsIfARestartAnswerIsDoubtful) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  for (const bool are_all_doubted : {false, true}) {
    std::vector<Trajectory> guesses;
    const SolverInfo lucky = converging_at(3, guesses, 100), other = failing(), *used = nullptr;
    const std::vector<const SolverInfo*> both{&lucky, &other};
    int asked = 0;
    const Doubt doubt = [&](const ShootingProblem&, const SolveResult&) {
      return Objection{++asked < 3 || are_all_doubted ? "it is doubted" : ""};
    };
    const SolveResult result = solve(problem, both, {}, guess, used, doubt);
    EXPECT_EQ(result.status, SolveStatus::converged);
    EXPECT_EQ(used, &lucky);
    ASSERT_TRUE(result.restarts);
    EXPECT_EQ(result.restarts->answer, are_all_doubted ? 2 : 4) << "the first where none is better";
    EXPECT_EQ(result.restarts->starts, are_all_doubted ? 21 : 5);
    EXPECT_EQ(result.restarts->converged, 1);
  }
}

TEST(AutoSolver, LimitsStartsAndIterations) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const Trajectory guess = problem.create_trajectory();
  std::vector<Trajectory> guesses;
  const SolverInfo never = converging_at(0, guesses), other = failing(), *used = nullptr;
  const std::vector<const SolverInfo*> both{&never, &other}, alone{&never};
  const SolveResult result = solve(problem, both, {}, guess, used);
  EXPECT_EQ(result.status, SolveStatus::line_search_failed);
  ASSERT_TRUE(result.restarts);
  EXPECT_EQ(result.restarts->starts, 21);
  EXPECT_EQ(result.restarts->converged, 0);
  EXPECT_EQ(result.restarts->answer, 0);
  EXPECT_EQ(result.trajectory.u(0), guess.u(0));
  EXPECT_EQ(guesses.size(), 21u);
  // Restarts of seven iterations each share the limit.
  EXPECT_EQ(solve(problem, both, {.max_iterations = 20}, guess, used).restarts->starts, 4);
  SolverOptions stopped;
  stopped.interrupted = [] { return true; };
  EXPECT_FALSE(solve(problem, both, stopped, guess, used).restarts);
  EXPECT_FALSE(solve(problem, alone, {}, guess, used).restarts) << "a solver that was named";
}

/// A solver with this cost from the guess, and a lower cost elsewhere.
SolverInfo asking(std::string_view name, double cost, double elsewhere, int iterations = 7) {
  return {.name = name,
          .control_bounds = BoundSupport::exact,
          .constraints = ConstraintSupport::all,
          .run = [=](const ShootingProblem& problem, const SolverOptions& options,
                     const Trajectory& guess) {
            SolveResult result(problem);
            result.iterations = std::min(iterations, options.max_iterations);
            result.status = result.iterations < iterations ? SolveStatus::max_iterations
                                                           : SolveStatus::converged;
            result.trajectory = guess;
            result.cost = guess.u(0).isZero() ? cost : elsewhere;
            return result;
          }};
}

SolveResult best_of(const std::vector<const SolverInfo*>& list, const SolverInfo*& used,
                    const SolverOptions& options = {}, const Doubt& doubt = nullptr) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  return solve_best(problem, list, options, problem.create_trajectory(), used, doubt);
}

TEST(FurtherLook, ReturnsTheCheapestAnswerOfAll) {
  const SolverInfo first = asking("first", 5, 4), second = asking("second", 3, 2), *used = nullptr;
  const SolveResult result = best_of({&first, &second}, used);
  EXPECT_EQ(used, &second);
  EXPECT_EQ(result.cost, 2);
  ASSERT_EQ(result.attempts.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i) EXPECT_EQ(result.attempts[i].chosen, i == 2);
  EXPECT_EQ(result.attempts[0].solver, "first");
  EXPECT_EQ(result.attempts[0].cost, 5);
  EXPECT_EQ(result.attempts[1].cost, 3);
  EXPECT_EQ(result.attempts[2].start, 1);
  EXPECT_EQ(result.attempts[3].start, 2);
}

TEST(FurtherLook, KeepsTheFirstOfEqualAnswers) {
  const SolverInfo first = asking("first", 5, 5), second = asking("second", 5 - 1e-5, 5),
                   *used = nullptr;
  EXPECT_EQ(best_of({&first, &second}, used).cost, 5);
  EXPECT_EQ(used, &first);
}

TEST(FurtherLook, EndsWithItsWork) {
  const SolverInfo first = asking("first", 5, 4), second = asking("second", 3, 2, 400),
                   *used = nullptr;
  SolverOptions options;
  options.look_further = 0;
  EXPECT_EQ(best_of({&first, &second}, used, options).attempts.size(), 1u);
  EXPECT_EQ(used, &first);
  // A budget of fifty iterations: the second solver is truncated and nothing follows.
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  options.look_further = 50 * problem.knots() * 25;
  const SolveResult result = best_of({&first, &second}, used, options);
  EXPECT_EQ(used, &first);
  ASSERT_EQ(result.attempts.size(), 2u);
  EXPECT_EQ(result.attempts[1].status, SolveStatus::max_iterations);
  EXPECT_EQ(result.attempts[1].iterations, 50);
  EXPECT_EQ(result.status, SolveStatus::converged);
}

TEST(FurtherLook, PrefersAnswersWithoutObjections) {
  const SolverInfo first = asking("first", 1, 2), second = asking("second", 1, 3), *used = nullptr;
  const Doubt doubt = [](const ShootingProblem&, const SolveResult& answer) {
    const bool jumps = answer.cost == 1;
    return Objection{.text = jumps ? "it leads through a wall" : "", .jumps = jumps};
  };
  const SolveResult result = best_of({&first, &second}, used, {}, doubt);
  EXPECT_EQ(result.cost, 2);
  ASSERT_EQ(result.attempts.size(), 4u);
  EXPECT_EQ(result.attempts[0].objection, "it leads through a wall");
  EXPECT_TRUE(result.attempts[2].chosen);
}

TEST(FurtherLook, AnswerIsIndependentOfThreads) {
  const SolverInfo first = asking("first", 5, 4), second = asking("second", 6, 2),
                   third = asking("third", 4.5, 3), *used = nullptr;
  SolverOptions options;
  for (const int threads : {1, 2, 4}) {
    options.threads = threads;
    const SolveResult result = best_of({&first, &second, &third}, used, options);
    EXPECT_EQ(used, &third);
    EXPECT_EQ(result.cost, 3);
    std::string tried;
    for (const Attempt& a : result.attempts) tried += fmt::format("{} {}, ", a.solver, a.start);
    EXPECT_EQ(tried, "first 0, third 0, second 0, third 1, third 2, ");
  }
}

TEST(FurtherLook, ContinuesWhileAnswersJump) {
  int asked = 0;
  const SolverInfo first = asking("first", 1, 2), *used = nullptr;
  const Doubt doubt = [&](const ShootingProblem&, const SolveResult&) {
    const bool jumps = ++asked < 7;
    return Objection{.text = jumps ? "it leads through a wall" : "", .jumps = jumps};
  };
  const SolveResult result = best_of({&first}, used, {}, doubt);
  EXPECT_TRUE(result.attempts.at(6).chosen);
  EXPECT_EQ(result.attempts[6].start, 6);
  EXPECT_EQ(result.attempts.size(), 7u);
  asked = 0;
  SolverOptions none;
  none.look_further = 0;
  EXPECT_EQ(best_of({&first}, used, none, doubt).attempts.size(), 1u);
}

TEST(AutoSolver, ReturnsTheCheapestOfDoubtedAnswers) {
  const ShootingProblem problem = testing::unicycle_parking(0.6);
  const SolverInfo first = asking("first", 5, 5), second = asking("second", 4, 4), *used = nullptr;
  const std::vector<const SolverInfo*> both{&first, &second};
  for (const bool jumps : {false, true}) {
    const Doubt doubt = [=](const ShootingProblem&, const SolveResult&) {
      return Objection{.text = "it is doubted", .jumps = jumps};
    };
    const SolveResult result = solve(problem, both, {}, problem.create_trajectory(), used, doubt);
    EXPECT_EQ(result.cost, jumps ? 5 : 4) << "of motions that jump the cheapest is none";
  }
}

// Both answers are doubted; the doubted gain of the cheap one is below the cost difference.
TEST(FurtherLook, KeepsDoubtedAnswersThatCostLess) {
  const SolverInfo first = asking("first", 1, 8), second = asking("second", 9, 7), *used = nullptr;
  const Doubt doubt = [&](const ShootingProblem&, const SolveResult& answer) {
    const bool doubted = answer.cost == 1 || answer.cost == 9;
    return Objection{doubted ? "a Newton step would gain something" : ""};
  };
  EXPECT_EQ(best_of({&first, &second}, used, {}, doubt).cost, 1);
}

TEST(FurtherLook, ReportsATimeCut) {
  const SolverInfo first = asking("first", 5, 4), second = asking("second", 3, 2), *used = nullptr;
  SolverOptions options;
  options.max_time_s = 1e-9;
  const SolveResult result = best_of({&first, &second}, used, options);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_NE(result.message.find("was cut short"), std::string::npos) << result.message;
}

}  // namespace
}  // namespace conddp
