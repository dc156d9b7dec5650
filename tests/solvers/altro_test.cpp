#include <cmath>

#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

using testing::controls_of;
using testing::cuts;
using testing::dense_optimum;
using testing::LinearQuadratic;
using testing::make_dense;
using testing::with_constraints;

SolverOptions altro_options() {
  SolverOptions options;
  options.tolerances.constraint = 1e-8;
  options.augmented_lagrangian.sufficient_decrease = 0.1;
  options.max_iterations = 500;
  return options;
}

TEST(Altro, ReachesThePublishedOptimaExactly) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    for (const bool closed : {false, true}) {
      Trajectory guess = testing::constant_controls(problem, control);
      if (closed) {
        ASSERT_EQ(Evaluator(problem).simulate(guess), -1);
      }
      const SolveResult result = solve(problem, "altro", altro_options(), guess);
      EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
      EXPECT_NEAR(result.cost, cost, 1e-4 * cost) << name;
      EXPECT_LE(result.residuals.constraint, 1e-8) << name;
      EXPECT_LE(result.residuals.stationarity, 1e-6) << name;
      EXPECT_LE(result.residuals.complementarity, 1e-6) << name;
    }
  }
}

TEST(Altro, NewtonPolishesPenaltySolutionToRounding) {
  for (const bool closed : {false, true})
    for (const auto& [name, problem, control, cost] : testing::published_cases()) {
      SCOPED_TRACE(name + (closed ? ", simulated" : ""));
      Trajectory guess = testing::constant_controls(problem, control);
      if (closed) {
        ASSERT_EQ(Evaluator(problem).simulate(guess), -1);
      }
      const SolveResult result = solve(problem, "altro", altro_options(), guess);
      int steps = 0;
      for (const IterationRecord& row : result.log) {
        steps = std::max(steps, row.newton);
        if (row.newton > 0) {
          EXPECT_EQ(row.regularization, 0);
        }
      }
      EXPECT_GE(steps, 1);
      EXPECT_LE(steps, 8);
      // From the states of its guess, the pendulum is minimized to its tolerance before the damped
      // Newton steps converge.
      const bool by_minimization = !closed && name == "pendulum";
      EXPECT_LE(result.residuals.constraint, by_minimization ? 1e-8 : 1e-10);
    }
}

TEST(Altro, MatchesAnIndependentMethodOnConvexProblems) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -3, 3);
    const ShootingProblem problem = with_constraints(*lq.problem, cuts(lq));
    const Eigen::VectorXd expected = dense_optimum(problem, make_dense(lq, problem, -3, 3));
    SolverOptions options = altro_options();
    options.tolerances.stationarity = 1e-9;
    const SolveResult result = solve(problem, "altro", options, problem.create_trajectory());
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    EXPECT_LT((controls_of(result.trajectory) - expected).cwiseAbs().maxCoeff(), 1e-7) << seed;
    EXPECT_GT(result.constraint_multipliers.cwiseAbs().maxCoeff(), 1e-3) << seed;
    EXPECT_LE(result.residuals.complementarity, 1e-6) << seed;
  }
}

TEST(Registry, UnconstrainedSolversNameTheConstrainedOne) {
  const auto cases = testing::published_cases();
  for (const SolverInfo& solver : solvers()) {
    const auto reason = unsupported(solver, cases[0].problem);
    EXPECT_EQ(reason.has_value(), solver.constraints != ConstraintSupport::all) << solver.name;
    if (!reason) continue;
    EXPECT_NE(reason->find("'speed'"), std::string::npos) << *reason;
    EXPECT_NE(reason->find("supported by altro, proxddp, ipddp, ipopt"), std::string::npos)
        << *reason;
  }
}

}  // namespace
}  // namespace conddp
