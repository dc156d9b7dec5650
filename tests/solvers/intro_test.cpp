#include <cmath>

#include <gtest/gtest.h>

#include "solvers/linalg/row_elimination.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/conic_optimality.hpp"
#include "support/constrained_problems.hpp"
#include "support/dense_convex.hpp"

namespace conddp {
namespace {

using testing::Added;
using testing::controls_of;
using testing::LinearQuadratic;
using testing::with_constraints;

SolverOptions intro_options() {
  SolverOptions options = testing::tight_options();
  options.max_iterations = 200;
  return options;
}

Added equality(const std::string& name, const ShootingProblem& problem, std::vector<int> columns,
               std::vector<double> values, int first, int last) {
  const std::vector<double> zero(values.size(), 0.0);
  return {.name = name,
          .residual = coordinate_residual(problem.manifold(), std::move(columns)),
          .reference = std::move(values),
          .lower = zero,
          .upper = zero,
          .first = first,
          .last = last};
}

/// Waypoints of the state, a prescribed control, and a goal: some rows fit into stages, others must
/// propagate.
std::vector<Added> equalities(const ShootingProblem& problem) {
  const int N = problem.knots();
  const std::vector<double> zero(2, 0.0);
  return {equality("way", problem, {0, 1}, {0.3, -0.2}, 5, 5),
          {.name = "given",
           .residual = control_residual(problem.ndx(), 2),
           .reference = {0.1, -0.1},
           .lower = zero,
           .upper = zero,
           .first = N - 3,
           .last = N - 2},
          testing::goal_constraint(problem, std::vector<double>(problem.ndx(), 0.2))};
}

/// All controls at once from the dense optimality conditions.
Eigen::VectorXd dense_controls(const LinearQuadratic& lq, const ShootingProblem& problem,
                               double* cost = nullptr) {
  const testing::Dense dense = testing::make_dense(lq, problem, 0, 0);
  std::vector<int> rows;
  std::vector<double> target;
  for (const NodeConstraint& c : problem.constraints()) {
    for (int i = 0; i < c.term->rows; ++i) {
      rows.push_back(c.row + i);
      target.push_back(c.lower[i]);
    }
  }
  const int n = static_cast<int>(dense.g.size()), m = static_cast<int>(rows.size());
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(n + m, n + m);
  Eigen::VectorXd rhs(n + m);
  K.topLeftCorner(n, n) = dense.H;
  rhs.head(n) = -dense.g;
  for (int i = 0; i < m; ++i) {
    K.row(n + i).head(n) = dense.G.row(rows[i]);
    K.col(n + i).head(n) = dense.G.row(rows[i]).transpose();
    rhs[n + i] = target[i] - dense.d[rows[i]];
  }
  const Eigen::VectorXd U = K.completeOrthogonalDecomposition().solve(rhs).head(n);
  if (cost != nullptr) *cost = 0.5 * U.dot(dense.H * U) + dense.g.dot(U);
  return U;
}

TEST(RowElimination, MakesRowsOrthonormalAndKeepsTheirMeaning) {
  std::srand(3);
  const Eigen::MatrixXd A = Eigen::MatrixXd::Random(3, 6);
  RowElimination system(5, 6);
  for (int i = 0; i < 3; ++i) system.append() = A.row(i);
  system.append() = A.row(0) - 2 * A.row(2);
  system.append() = 3 * A.row(1);
  Eigen::MatrixXd before = system.rows();
  system.scale();
  EXPECT_EQ(system.orthonormalize(0, 0, 2), 2);
  EXPECT_EQ(system.orthonormalize(2, 2, 3), 1);
  const Eigen::MatrixXd after = system.rows();
  EXPECT_LT((after.topLeftCorner(2, 2) * after.topLeftCorner(2, 2).transpose() -
             Eigen::Matrix2d::Identity())
                .norm(),
            1e-14);
  EXPECT_LT(after.bottomLeftCorner(3, 2).norm(), 1e-14);
  EXPECT_LT(after.bottomRows(2).norm(), 1e-13);
  // yᵀ (rows before) = ηᵀ (rows after)
  const Eigen::VectorXd eta = Eigen::VectorXd::Random(5);
  Eigen::VectorXd y(5);
  system.original_multipliers(eta, y);
  EXPECT_LT((before.transpose() * y - after.transpose() * eta).norm(), 1e-13);
}

TEST(Intro, SolvesLinearQuadraticProblemsInOneStep) {
  for (const unsigned seed : {1u, 2u, 3u, 4u, 5u, 6u}) {
    const LinearQuadratic lq(seed, 5, {3, 2}, 8, -testing::kFree, testing::kFree);
    const ShootingProblem problem = with_constraints(*lq.problem, equalities(*lq.problem));
    for (const bool open : {false, true}) {
      const Trajectory guess =
          open ? testing::random_guess(problem, seed) : problem.create_trajectory();
      const SolveResult result = solve(problem, "intro", intro_options(), guess);
      EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
      EXPECT_EQ(result.iterations, 1) << seed;
      EXPECT_LT(
          (controls_of(result.trajectory) - dense_controls(lq, problem)).cwiseAbs().maxCoeff(),
          1e-7)
          << seed;
      EXPECT_GT(result.constraint_multipliers.cwiseAbs().maxCoeff(), 1e-3) << seed;
    }
  }
}

TEST(Intro, AgreesWithTheOthersOnEqualities) {
  const LinearQuadratic lq(4, 5, {3, 2}, 8, -testing::kFree, testing::kFree);
  const ShootingProblem problem = with_constraints(*lq.problem, equalities(*lq.problem));
  const Trajectory guess = problem.create_trajectory();
  const SolveResult result = solve(problem, "intro", intro_options(), guess);
  for (const char* other : {"altro", "proxddp"}) {
    const SolveResult its = solve(problem, other, intro_options(), guess);
    EXPECT_EQ(its.status, SolveStatus::converged) << its.message;
    EXPECT_LT(testing::control_distance(result, its), 1e-7) << other;
    EXPECT_LT((result.constraint_multipliers - its.constraint_multipliers).cwiseAbs().maxCoeff(),
              1e-5)
        << other;
  }
}

TEST(Intro, ReachesNonlinearGoalsLikeAltro) {
  const ShootingProblem pendulum = testing::pendulum_swing_up();
  const ShootingProblem parking = testing::unicycle_parking();
  const ShootingProblem problems[] = {
      with_constraints(parking, {testing::goal_constraint(parking, {3, 3, 0})}),
      with_constraints(pendulum, {testing::goal_constraint(pendulum, {M_PI, 0})})};
  for (const ShootingProblem& problem : problems) {
    SolverOptions options;
    options.tolerances.constraint = 1e-8;
    const Trajectory guess = testing::constant_controls(problem, 0.01);
    const SolveResult result = solve(problem, "intro", options, guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
    const SolveResult altro = solve(problem, "altro", options, guess);
    EXPECT_NEAR(result.cost, altro.cost, 1e-4 * altro.cost);
  }
}

TEST(Intro, RowsPropagateThroughKnotsWithoutControls) {
  const ShootingProblem landing = testing::landing();
  // After touch-down, the hips are at this height.
  const ShootingProblem problem =
      with_constraints(landing, {equality("height", landing, {1}, {0.53}, 11, 11)});
  const SolveResult result = solve(problem, "intro", {}, testing::constant_controls(problem, 0.01));
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.trajectory.x(11)[1], 0.53, 1e-6);
}

TEST(Intro, DependentRowsDoNoHarm) {
  const LinearQuadratic lq(3, 5, {3, 2}, 8, -testing::kFree, testing::kFree);
  const std::vector<Added> list = equalities(*lq.problem);
  std::vector<Added> more = list;
  more.push_back(list[2]);
  more.back().name = "goal again";
  more.push_back(equality("way again", *lq.problem, {1}, {-0.2}, 5, 5));
  const ShootingProblem once = with_constraints(*lq.problem, list);
  const ShootingProblem twice = with_constraints(*lq.problem, more);
  const SolveResult a = solve(once, "intro", intro_options(), once.create_trajectory());
  const SolveResult b = solve(twice, "intro", intro_options(), twice.create_trajectory());
  EXPECT_EQ(b.status, SolveStatus::converged) << b.message;
  EXPECT_LT(testing::control_distance(a, b), 1e-7);
}

TEST(Intro, ContradictionsEndAsInfeasible) {
  const LinearQuadratic lq(3, 5, {3, 2}, 8, -testing::kFree, testing::kFree);
  std::vector<Added> list = equalities(*lq.problem);
  list.push_back(equality("elsewhere", *lq.problem, {1}, {0.5}, 5, 5));
  const ShootingProblem problem = with_constraints(*lq.problem, list);
  const SolveResult result = solve(problem, "intro", intro_options(), problem.create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::infeasible) << result.message;
}

TEST(Intro, RejectsInequalitiesByName) {
  const LinearQuadratic lq(3, 4, {3, 2}, 8, -testing::kFree, testing::kFree);
  const ShootingProblem problem = with_constraints(*lq.problem, testing::cuts(lq));
  const auto reason = unsupported(*find_solver("intro"), problem);
  ASSERT_TRUE(reason);
  EXPECT_NE(reason->find("intro does not support the inequality 'cone'"), std::string::npos)
      << *reason;
  EXPECT_NE(reason->find("; supported by altro, proxddp, ipddp, ipopt"), std::string::npos)
      << *reason;
}

TEST(Intro, WithoutConstraintsItMatchesFddp) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  const Trajectory guess = testing::constant_controls(problem, 0.01);
  const SolveResult a = solve(problem, "intro", {}, guess);
  const SolveResult b = solve(problem, "fddp", {}, guess);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.iterations, b.iterations);
}

}  // namespace
}  // namespace conddp
