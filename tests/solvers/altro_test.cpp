#include <cmath>

#include <gtest/gtest.h>

#include "solvers/constrained.hpp"
#include "solvers/dense_convex.hpp"
#include "solvers/registry.hpp"

namespace conddp {
namespace {

using testing::Added;
using testing::controls_of;
using testing::cuts;
using testing::Dense;
using testing::dense_optimum;
using testing::LinearQuadratic;
using testing::make_dense;
using testing::with_constraints;

SolverOptions strict() {
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
        ASSERT_EQ(Acts(problem).simulate(guess), -1);
      }
      const SolveResult result = solve(problem, "altro", strict(), guess);
      EXPECT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
      EXPECT_NEAR(result.cost, cost, 1e-4 * cost) << name;
      EXPECT_LE(result.residuals.constraint, 1e-8) << name;
      EXPECT_LE(result.residuals.stationarity, 1e-6) << name;
      EXPECT_LE(result.residuals.complementarity, 1e-6) << name;
      EXPECT_LE(result.iterations, 120) << name;
    }
  }
}

TEST(Altro, NewtonTakesAConvergedPenaltySolutionToRoundingInFewSteps) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    const SolveResult result =
        solve(problem, "altro", strict(), testing::constant_controls(problem, control));
    int steps = 0;
    for (const IterationRecord& row : result.log) {
      steps = std::max(steps, row.newton);
      if (row.newton > 0) {
        EXPECT_EQ(row.regularization, 0);
      }
    }
    EXPECT_GE(steps, 1) << name;
    EXPECT_LE(steps, 8) << name;
    EXPECT_LE(result.residuals.constraint, 1e-10) << name;
  }
}

TEST(Altro, SolvesConvexProblemsAsAnIndependentMethodDoes) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const LinearQuadratic lq(seed, 4, {3, 2}, 8, -3, 3);
    const ShootingProblem problem = with_constraints(*lq.problem, cuts(lq));
    const Eigen::VectorXd expected = dense_optimum(problem, make_dense(lq, problem, -3, 3));
    SolverOptions options = strict();
    options.tolerances.stationarity = 1e-9;
    const SolveResult result = solve(problem, "altro", options, problem.create_trajectory());
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    EXPECT_LT((controls_of(result.trajectory) - expected).cwiseAbs().maxCoeff(), 1e-7) << seed;
    EXPECT_GT(result.constraint_multipliers.cwiseAbs().maxCoeff(), 1e-3) << seed;
    EXPECT_LE(result.residuals.complementarity, 1e-6) << seed;
  }
}

TEST(Altro, MultipliersMakeTheLagrangianStationary) {
  const LinearQuadratic lq(2, 4, {3, 2}, 8, -3, 3);
  const ShootingProblem problem = with_constraints(*lq.problem, cuts(lq));
  const SolveResult result = solve(problem, "altro", strict(), problem.create_trajectory());
  const Dense dense = make_dense(lq, problem, -3, 3);
  Eigen::VectorXd gradient = dense.H * controls_of(result.trajectory) + dense.g +
                             dense.G.transpose() * result.constraint_multipliers;
  int at = 0;
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i, ++at)
      EXPECT_NEAR(gradient[at],
                  std::abs(result.trajectory.u(k)[i]) == 3 ? result.control_gradient[k][i] : 0.0,
                  1e-6);
}

TEST(Altro, RedundantConstraintsDoNoHarm) {
  const LinearQuadratic lq(3, 4, {3, 2}, 8, -3, 3);
  std::vector<Added> list = cuts(lq);
  list.push_back(list[1]);
  list.back().name = "end again";
  const ShootingProblem twice = with_constraints(*lq.problem, list);
  const ShootingProblem once = with_constraints(*lq.problem, cuts(lq));
  const SolveResult a = solve(twice, "altro", strict(), twice.create_trajectory());
  const SolveResult b = solve(once, "altro", strict(), once.create_trajectory());
  EXPECT_EQ(a.status, SolveStatus::converged) << a.message;
  EXPECT_LT((controls_of(a.trajectory) - controls_of(b.trajectory)).cwiseAbs().maxCoeff(), 1e-6);
}

TEST(Altro, ContradictionsEndAsInfeasibleAndNameTheConstraint) {
  const auto mass = testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1,
                                              {0, 0}, {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  // With 3 N for 2 s the mass gets no further than 3 m at rest.
  const ShootingProblem too_far = with_constraints(mass, {testing::goal_constraint(mass, {5, 0})});
  SolveResult result = solve(too_far, "altro", strict(), too_far.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::infeasible) << result.message;
  EXPECT_NE(result.message.find("'terminal/goal'"), std::string::npos) << result.message;
  EXPECT_GT(result.residuals.constraint, 1);

  Added other = testing::goal_constraint(mass, {0.5, 0});
  other.name = "other";
  const ShootingProblem both =
      with_constraints(mass, {testing::goal_constraint(mass, {1, 0}), other});
  result = solve(both, "altro", strict(), both.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::infeasible) << result.message;
}

TEST(Altro, NumbersThatAreNoneEndAsDiverged) {
  const auto mass = testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1,
                                              {0, 0}, {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  const ShootingProblem problem = with_constraints(
      mass, {testing::goal_constraint(mass, {std::numeric_limits<double>::quiet_NaN(), 0})});
  const SolveResult result = solve(problem, "altro", strict(), problem.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::diverged) << result.message;
}

TEST(Altro, WithoutConstraintsItIsBoxFddp) {
  const ShootingProblem problem = testing::cartpole_swing_up(3);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolveResult a = solve(problem, "altro", {}, guess);
  const SolveResult b = solve(problem, "box_fddp", {}, guess);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST(Altro, ResultsAreTheSameBitsWithTwoThreads) {
  const auto cases = testing::published_cases();
  const Trajectory guess = testing::constant_controls(cases[2].problem, cases[2].control);
  SolverOptions options = strict();
  const SolveResult one = solve(cases[2].problem, "altro", options, guess);
  options.threads = 2;
  const SolveResult two = solve(cases[2].problem, "altro", options, guess);
  EXPECT_EQ(one.iterations, two.iterations);
  EXPECT_EQ(controls_of(one.trajectory), controls_of(two.trajectory));
  EXPECT_EQ(one.constraint_multipliers, two.constraint_multipliers);
}

TEST(Registry, SolversWithoutConstraintsNameTheOneThatHasThem) {
  const auto cases = testing::published_cases();
  for (const SolverInfo& solver : solvers()) {
    const auto reason = refuse(solver, cases[0].problem);
    EXPECT_EQ(reason.has_value(), solver.constraints != ConstraintSupport::all) << solver.name;
    if (!reason) continue;
    EXPECT_NE(reason->find("'speed'"), std::string::npos) << *reason;
    EXPECT_NE(reason->find("altro, proxddp, ipopt can"), std::string::npos) << *reason;
  }
}

}  // namespace
}  // namespace conddp
