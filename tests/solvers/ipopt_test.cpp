#include <cmath>

#include <gtest/gtest.h>

#include "nlp/chain_factorization.hpp"
#include "nlp/inequality_elimination.hpp"
#include "solvers/ipopt/ipopt_solver.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"

namespace conddp {
namespace {

using testing::Added;
using testing::with_constraints;

ShootingProblem mass() {
  return testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {0, 0},
                                   {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
}

TEST(Ipopt, AgreesWithAltroOnPublishedCases) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    Trajectory guess = testing::constant_controls(problem, control);
    const SolveResult altro = solve(problem, "altro", {}, guess);
    SolverOptions options;
    if (name == "three obstacles") {
      // Several routes around them exist; this is altro's, with a barrier that stays there.
      guess = altro.trajectory;
      options.ipopt = {{"mu_init", 1e-6}, {"bound_push", 1e-8}, {"bound_frac", 1e-8}};
    }
    const SolveResult result = solve(problem, "ipopt", options, guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
    EXPECT_NEAR(result.cost, altro.cost, 1e-6 * altro.cost) << name;
    EXPECT_LE(result.residuals.stationarity, 1e-6) << name;
    EXPECT_LE(result.residuals.gap, 1e-9) << name;
    EXPECT_LE(result.residuals.constraint, 1e-6) << name;
    EXPECT_LE(result.residuals.complementarity, 1e-6) << name;
    for (int k = 0; k < problem.knots(); ++k)
      for (int i = 0; i < problem.nu(k); ++i) {
        const KnotModel& model = *problem.knot(k).model;
        EXPECT_GE(result.trajectory.u(k)[i], model.control_lower()[i]);
        EXPECT_LE(result.trajectory.u(k)[i], model.control_upper()[i]);
      }
  }
}

/// Multipliers, costates, and gains match altro's at the same optimum.
TEST(Ipopt, AgreesWithAltroAtAnOptimum) {
  const auto cases = testing::published_cases();
  const ShootingProblem& problem = cases[0].problem;
  const Trajectory guess = testing::constant_controls(problem, 0);
  const SolveResult a = solve(problem, "ipopt", {}, guess), b = solve(problem, "altro", {}, guess);
  EXPECT_GT(b.constraint_multipliers.lpNorm<Eigen::Infinity>(), 1e-3);
  EXPECT_LE((a.constraint_multipliers - b.constraint_multipliers).lpNorm<Eigen::Infinity>(), 1e-5);
  EXPECT_LE((a.costates - b.costates).rightCols(problem.knots()).lpNorm<Eigen::Infinity>(), 1e-5);
  ASSERT_TRUE(a.feedback_regularization);
  EXPECT_EQ(*a.feedback_regularization, 0);
}

TEST(Ipopt, KeepsConesOnTheirSurface) {
  const ShootingProblem free = testing::unicycle_parking(3);
  const ShootingProblem problem =
      with_constraints(free, {{.name = "wedge",
                               .residual = coordinate_residual(free.manifold(), {0, 1}),
                               .kind = ConstraintKind::second_order_cone,
                               .reference = {0, -1},
                               .first = 1,
                               .last = 100,
                               .slope = 0.5}});
  const Trajectory guess = testing::constant_controls(problem, 0.1);
  const SolveResult result = solve(problem, "ipopt", {}, guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_GT(result.constraint_multipliers.lpNorm<Eigen::Infinity>(), 1e-3);
  for (const NodeConstraint& c : problem.constraints()) {
    const double* g = result.constraint_values.data() + c.row;
    const double* nu = result.constraint_multipliers.data() + c.row;
    EXPECT_LE(distance_to_set(*c.term, g, c.lower, c.upper), 1e-6);
    EXPECT_LE(complementarity(*c.term, g, c.lower, c.upper, nu), 1e-6) << c.node;
  }
}

TEST(Ipopt, HessiansOfEveryKindReachTheOptimum) {
  const auto cases = testing::published_cases();
  const ShootingProblem& problem = cases[0].problem;
  const Trajectory guess = testing::constant_controls(problem, cases[0].control);
  SolverOptions limited;
  limited.ipopt = {{"hessian_approximation", "limited-memory"}};
  const SolveResult exact = solve(problem, "ipopt", {}, guess);
  const SolveResult lbfgs = solve(problem, "ipopt", limited, guess);
  const SolveResult gauss_newton =
      solve(problem, "ipopt", {.hessian = HessianChoice::gauss_newton}, guess);
  for (const SolveResult* result : {&exact, &lbfgs, &gauss_newton}) {
    EXPECT_EQ(result->status, SolveStatus::converged) << result->message;
    EXPECT_NEAR(result->cost, exact.cost, 1e-6 * exact.cost);
  }
  EXPECT_TRUE(exact.log.back().exact_hessian);
  EXPECT_FALSE(lbfgs.log.back().exact_hessian);
  EXPECT_FALSE(gauss_newton.log.back().exact_hessian);
}

TEST(Ipopt, ExactHessiansNeedFewerIterationsThanLimitedMemory) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  const Trajectory guess = testing::constant_controls(problem, 0.1);
  const SolveResult exact = solve(problem, "ipopt", {}, guess);
  EXPECT_EQ(exact.status, SolveStatus::converged) << exact.message;
  SolverOptions limited{.max_iterations = exact.iterations};
  limited.ipopt = {{"hessian_approximation", "limited-memory"}};
  EXPECT_EQ(solve(problem, "ipopt", limited, guess).status, SolveStatus::max_iterations);
}

/// A rotation by more than π about a changing axis leaves every chart that starts at the guess.
TEST(Ipopt, ContinuesInNewChartsForLargeRotations) {
  const ShootingProblem free = testing::quadrotor_move(0, 30);
  const double half = 0.5 * 3.1;
  const ShootingProblem problem = with_constraints(
      free, {testing::goal_constraint(
                free, {0.5, 0, 1, 0, 0, std::sin(half), std::cos(half), 0, 0, 0, 0, 0, 0})});
  const Trajectory guess = testing::constant_controls(problem, 1.22625);
  const SolveResult result = solve(problem, "ipopt", {}, guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  const SolveResult altro = solve(problem, "altro", {}, result.trajectory);
  EXPECT_NEAR(result.cost, altro.cost, 1e-6 * altro.cost);
  for (std::size_t i = 1; i < result.log.size(); ++i)
    EXPECT_EQ(result.log[i].iteration, result.log[i - 1].iteration + 1);
}

TEST(Ipopt, ContradictionsEndAsInfeasible) {
  const ShootingProblem free = mass();
  // With 3 N for 2 s, the mass reaches at most 3 m at rest.
  const ShootingProblem too_far = with_constraints(free, {testing::goal_constraint(free, {5, 0})});
  const SolveResult result = solve(too_far, "ipopt", {}, too_far.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::infeasible) << result.message;
  EXPECT_GT(result.residuals.constraint, 0.1);

  const ShootingProblem from_outside =
      with_constraints(free, {{.name = "right side",
                               .residual = coordinate_residual(free.manifold(), {0}),
                               .reference = {0},
                               .lower = {0.5},
                               .upper = {testing::kFree},
                               .first = 0,
                               .last = 0}});
  const SolveResult outside = solve(from_outside, "ipopt", {}, from_outside.create_trajectory());
  EXPECT_EQ(outside.status, SolveStatus::infeasible) << outside.message;
  EXPECT_NE(outside.message.find("initial state"), std::string::npos) << outside.message;
}

TEST(Ipopt, NonFiniteNumbersEndAsDiverged) {
  const ShootingProblem free = mass();
  const ShootingProblem problem = with_constraints(
      free, {testing::goal_constraint(free, {std::numeric_limits<double>::quiet_NaN(), 0})});
  const SolveResult result = solve(problem, "ipopt", {}, problem.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::diverged) << result.message;
}

TEST(Ipopt, RespectsBudgetsAndReturnsBestIterate) {
  const ShootingProblem problem = testing::cartpole_swing_up(3);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  SolveResult result = solve(problem, "ipopt", {.max_time_s = 0}, guess);
  EXPECT_EQ(result.status, SolveStatus::time_limit);
  EXPECT_EQ(result.iterations, 0);
  int polls = 0;
  SolverOptions options;
  options.interrupted = [&] { return ++polls > 8; };
  result = solve(problem, "ipopt", options, guess);
  EXPECT_EQ(result.status, SolveStatus::interrupted);
  EXPECT_EQ(result.iterations, 8);
  ASSERT_GE(result.log.size(), 9u);
  const auto error = [](const IterationRecord& row) {
    return std::max({row.gap, row.constraint, row.stationarity, row.complementarity});
  };
  const auto best = std::min_element(
      result.log.begin(), result.log.begin() + 9,
      [&](const IterationRecord& a, const IterationRecord& b) { return error(a) < error(b); });
  EXPECT_EQ(result.cost, best->cost);
  EXPECT_EQ(result.log.back().cost, result.cost);
  EXPECT_TRUE(result.costates.allFinite());
}

/// With such large weights, rounding keeps Newton's method above its goal. It continues, and its
/// last iterate is not always its best.
TEST(Ipopt, AnswerIsBestNewtonIterate) {
  for (const double weight : {1e4, 1e5, 1e6}) {
    const ShootingProblem free =
        testing::tracking_problem(pendulum({}), Integrator::rk4, 50, 0.06, {0, 0},
                                  {{M_PI, 0}, {weight, weight}, {weight}, {weight, weight}}, -3, 3);
    const ShootingProblem problem =
        with_constraints(free, {testing::goal_constraint(free, {M_PI, 0})});
    const SolverOptions options{.tolerances = {.stationarity = 1e-12 * weight}};
    const SolveResult result =
        solve(problem, "ipopt", options, testing::constant_controls(problem, 0.1));
    EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
    int newton = 0;
    for (std::size_t i = 1; i < result.log.size(); ++i) {
      const IterationRecord& row = result.log[i];
      if (row.newton == result.log[i - 1].newton) continue;
      ++newton;
      // Newton's iterates meet all other tolerances.
      EXPECT_LE(result.residuals.stationarity, row.stationarity)
          << weight << ", iteration " << row.iteration;
    }
    EXPECT_GE(newton, 1) << weight;
    EXPECT_EQ(result.log.back().cost, result.cost);
  }
}

TEST(Ipopt, LogsItsIterations) {
  const auto cases = testing::published_cases();
  SolverOptions options;
  int rows = 0;
  options.on_iteration = [&](const IterationRecord& row) { EXPECT_EQ(row.iteration, rows++); };
  const SolveResult result =
      solve(cases[0].problem, "ipopt", options, testing::constant_controls(cases[0].problem, 0));
  EXPECT_EQ(static_cast<int>(result.log.size()), rows);
  EXPECT_EQ(result.iterations + 1, rows);
  EXPECT_GT(result.log[1].barrier, 0);
  EXPECT_GT(result.log[1].step, 0);
  EXPECT_GE(result.log[1].trials, 1);
  EXPECT_GE(result.log.back().newton, 1);
  EXPECT_GT(result.log.back().active_rows, 0);
  EXPECT_NEAR(result.log.back().cost, result.cost, 1e-12);
}

TEST(Ipopt, RejectsUnknownOptions) {
  const ShootingProblem problem = mass();
  const Trajectory guess = problem.create_trajectory();
  const auto message = [&](const SolverOptions& options) {
    try {
      solve(problem, "ipopt", options, guess);
    } catch (const std::invalid_argument& fault) {
      return std::string(fault.what());
    }
    return std::string();
  };
  SolverOptions options;
  options.ipopt = {{"mu_stratgy", "adaptive"}};
  EXPECT_EQ(message(options), "Ipopt has no option 'mu_stratgy'");
  options.ipopt = {{"hessian_approximation", "limited-memory"}};
  options.hessian = HessianChoice::exact;
  EXPECT_NE(message(options).find("hessian must be automatic"), std::string::npos);
}

// 20 knots of two states and a control plus the terminal state give 62 directions, and a chain
// takes at most 124 rows: three constraints on both states at all knots, and four rows at the end.
TEST(Ipopt, FactorizesAlongTheHorizonForEachDirection) {
  const ShootingProblem problem = mass();
  ASSERT_EQ(problem.constraint_rows(), 0);
  const auto state = [&](std::string name, int first, int last) {
    return Added{.name = std::move(name),
                 .residual = state_residual(problem.manifold()),
                 .reference = {0, 0},
                 .lower = {-9, -9},
                 .upper = {9, 9},
                 .first = first,
                 .last = last};
  };
  std::vector<Added> list = {state("a", 0, 19), state("b", 0, 19), state("c", 0, 19),
                             state("d", 20, 20), state("e", 20, 20)};
  const ShootingProblem most = with_constraints(problem, list);
  EXPECT_EQ(most.constraint_rows(), 124);
  list.push_back(state("f", 20, 20));
  const ShootingProblem more = with_constraints(problem, list);
  EXPECT_EQ(factorization_along_horizon(most), ChainFactorization::make);
  EXPECT_EQ(factorization_along_horizon(more), InequalityElimination::make);
  std::vector<Added> equal = list;
  for (Added& added : equal) added.upper = added.lower;
  EXPECT_EQ(factorization_along_horizon(with_constraints(problem, equal)), nullptr);

  // Seven copies of speed limits; some are active.
  for (Added& added : list) {
    added.lower = {-9, -0.1};
    added.upper = {9, 0.1};
  }
  const ShootingProblem slow = with_constraints(problem, list);
  SolverOptions options;
  const SolveResult ours = solve(slow, "ipopt", options, slow.create_trajectory());
  options.ipopt = {{"linear_solver", "mumps"}};
  const SolveResult theirs = solve(slow, "ipopt", options, slow.create_trajectory());
  ASSERT_EQ(ours.status, SolveStatus::converged) << ours.message;
  EXPECT_NEAR(ours.cost, theirs.cost, 1e-10 * theirs.cost);
  EXPECT_GT(ours.cost, 1.001 * solve(problem, "ipopt", {}, problem.create_trajectory()).cost);
}

}  // namespace
}  // namespace conddp
