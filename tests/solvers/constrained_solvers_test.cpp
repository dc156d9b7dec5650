#include <limits>

#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

// Properties of every DDP solver that supports all kinds of constraints.

namespace conddp {
namespace {

using testing::Added;
using testing::controls_of;
using testing::cuts;
using testing::LinearQuadratic;
using testing::with_constraints;

class ConstrainedSolver : public ::testing::TestWithParam<const char*> {
 protected:
  SolveResult run(const ShootingProblem& problem) const {
    return solve(problem, GetParam(), testing::tight_options(), problem.create_trajectory());
  }
};

INSTANTIATE_TEST_SUITE_P(Registered, ConstrainedSolver, ::testing::Values("altro", "proxddp"),
                         [](const auto& solver) { return std::string(solver.param); });

/// 1 kg with at most 3 N for 2 s: it reaches at most 3 m at rest.
ShootingProblem sliding_mass() {
  return testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {0, 0},
                                   {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
}

TEST_P(ConstrainedSolver, MultipliersMakeTheLagrangianStationary) {
  const LinearQuadratic lq(2, 4, {3, 2}, 8, -3, 3);
  const ShootingProblem problem = with_constraints(*lq.problem, cuts(lq));
  const SolveResult result = run(problem);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const testing::Dense dense = testing::make_dense(lq, problem, -3, 3);
  const Eigen::VectorXd gradient = dense.H * controls_of(result.trajectory) + dense.g +
                                   dense.G.transpose() * result.constraint_multipliers;
  int at = 0;
  for (int k = 0; k < problem.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i, ++at)
      EXPECT_NEAR(gradient[at],
                  std::abs(result.trajectory.u(k)[i]) == 3 ? result.control_gradient[k][i] : 0.0,
                  1e-8);
}

// Bryson and Denham (1963): a mass is thrown at a wall at distance ℓ and returns with minimum ∫
// u²/2. For ℓ ≤ 1/6 the optimum is 4/(9 ℓ), and the wall multipliers grow as ℓ shrinks.
TEST_P(ConstrainedSolver, ReturnsFromWallsAtAnyDistance) {
  for (const int knots : {25, 50, 100, 200, 300}) {
    for (const double fraction : {5, 6, 8, 9, 12, 16, 32, 64}) {
      const double wall = 1 / fraction;
      const ShootingProblem free =
          testing::tracking_problem(double_integrator(1), Integrator::rk4, knots, 1.0 / knots,
                                    {0, 1}, {{0, 0}, {0, 0}, {1}, {0, 0}, true});
      const ShootingProblem problem = with_constraints(
          free, {testing::goal_constraint(free, {0, -1}), Added{"wall",
                                                                state_residual(free.manifold()),
                                                                ConstraintKind::bounds,
                                                                {0, 0},
                                                                {-testing::kFree, -testing::kFree},
                                                                {wall, testing::kFree},
                                                                0,
                                                                knots}});
      const SolveResult result = solve(problem, GetParam(), {}, problem.create_trajectory());
      EXPECT_EQ(result.status, SolveStatus::converged)
          << knots << " knots, 1/" << 1 / wall << ": " << result.message;
      // Controls are constant over knots, and the wall holds at knots.
      if (knots * wall > 6 && fraction >= 6) {
        EXPECT_NEAR(result.cost, 4 / (9 * wall), 0.05 * result.cost);
      }
    }
  }
}

// Rounding leaves one residual above a zero tolerance while the others are within theirs.
TEST_P(ConstrainedSolver, ConvergedMeansAllResidualsAreUnderTolerance) {
  for (const auto& [name, problem, control, cost] : testing::published_cases())
    for (double SolverOptions::Tolerances::*impossible :
         {&SolverOptions::Tolerances::stationarity, &SolverOptions::Tolerances::complementarity}) {
      SolverOptions options;
      options.tolerances.*impossible = 1e-300;
      options.max_iterations = 100;
      const SolveResult result =
          solve(problem, GetParam(), options, testing::constant_controls(problem, control));
      const Residuals& r = result.residuals;
      const auto& t = options.tolerances;
      EXPECT_EQ(result.status == SolveStatus::converged,
                r.stationarity <= t.stationarity && r.gap <= t.gap &&
                    r.constraint <= t.constraint && r.complementarity <= t.complementarity)
          << name << ": " << result.message;
    }
}

// Newton's last iterate is the answer; its residuals use different gains than Newton's.
TEST_P(ConstrainedSolver, LastLogRowDescribesTheAnswer) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    const SolveResult result =
        solve(problem, GetParam(), {}, testing::constant_controls(problem, control));
    const IterationRecord& last = result.log.back();
    EXPECT_EQ(last.iteration, result.iterations) << name;
    EXPECT_EQ(last.cost, result.cost) << name;
    EXPECT_EQ(last.stationarity, result.residuals.stationarity) << name;
    EXPECT_EQ(last.gap, result.residuals.gap) << name;
    EXPECT_EQ(last.constraint, result.residuals.constraint) << name;
    EXPECT_EQ(last.complementarity, result.residuals.complementarity) << name;
  }
}

TEST_P(ConstrainedSolver, RedundantConstraintsDoNoHarm) {
  const LinearQuadratic lq(3, 4, {3, 2}, 8, -3, 3);
  std::vector<Added> list = cuts(lq);
  list.push_back(list[1]);
  list.back().name = "end again";
  list.push_back(list[2]);
  list.back().name = "cone again";
  const SolveResult twice = run(with_constraints(*lq.problem, list));
  const SolveResult once = run(with_constraints(*lq.problem, cuts(lq)));
  EXPECT_EQ(twice.status, SolveStatus::converged) << twice.message;
  EXPECT_LT((controls_of(twice.trajectory) - controls_of(once.trajectory)).cwiseAbs().maxCoeff(),
            1e-7);
}

TEST_P(ConstrainedSolver, ContradictionsEndAsInfeasibleAndNameTheConstraint) {
  const ShootingProblem mass = sliding_mass();
  SolveResult result = run(with_constraints(mass, {testing::goal_constraint(mass, {5, 0})}));
  EXPECT_EQ(result.status, SolveStatus::infeasible) << result.message;
  EXPECT_NE(result.message.find("'terminal/goal'"), std::string::npos) << result.message;
  EXPECT_GT(result.residuals.constraint, 1);

  Added other = testing::goal_constraint(mass, {0.5, 0});
  other.name = "other";
  result = run(with_constraints(mass, {testing::goal_constraint(mass, {1, 0}), other}));
  EXPECT_EQ(result.status, SolveStatus::infeasible) << result.message;
}

TEST_P(ConstrainedSolver, NonFiniteNumbersEndAsDiverged) {
  const ShootingProblem mass = sliding_mass();
  const SolveResult result = run(with_constraints(
      mass, {testing::goal_constraint(mass, {std::numeric_limits<double>::quiet_NaN(), 0})}));
  EXPECT_EQ(result.status, SolveStatus::diverged) << result.message;
}

TEST_P(ConstrainedSolver, WithoutConstraintsItMatchesBoxFddp) {
  const ShootingProblem problem = testing::cartpole_swing_up(3);
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolveResult a = solve(problem, GetParam(), {}, guess);
  const SolveResult b = solve(problem, "box_fddp", {}, guess);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.iterations, b.iterations);
}

TEST_P(ConstrainedSolver, ResultsAreBitwiseEqualWithTwoThreads) {
  const auto cases = testing::published_cases();
  const Trajectory guess = testing::constant_controls(cases[2].problem, cases[2].control);
  SolverOptions options;
  const SolveResult one = solve(cases[2].problem, GetParam(), options, guess);
  options.threads = 2;
  const SolveResult two = solve(cases[2].problem, GetParam(), options, guess);
  EXPECT_EQ(one.iterations, two.iterations);
  EXPECT_EQ(controls_of(one.trajectory), controls_of(two.trajectory));
  EXPECT_EQ(one.constraint_multipliers, two.constraint_multipliers);
}

}  // namespace
}  // namespace conddp
