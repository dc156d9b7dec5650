// Curvature and Newton gain on the active constraints, at analytic points and dense optima.
#include "analysis/certificate/second_order.hpp"

#include <gtest/gtest.h>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/certificate_doubt.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/one_step.hpp"

namespace conddp {
namespace {

using Eigen::VectorXd;

/// Second-order check at a solver's answer, which may have been moved.
SecondOrder at_answer(const ShootingProblem& problem, const SolveResult& result) {
  const NodeValues values(problem, result.trajectory);
  const Certificate found = certify(problem, claims_of(problem, result, values, {}), values);
  return found.second_order.value_or(SecondOrder());
}

/// Second-order check of a step u with this constraint multiplier.
SecondOrder at_step(const ShootingProblem& problem, const VectorXd& u, const VectorXd& costate,
                    const VectorXd& multiplier, double cost) {
  SolutionClaims claims = testing::claims_of(problem, u, costate, cost);
  claims.multipliers = multiplier;
  return *certify(problem, claims).second_order;
}

/// Minimizes ½ ‖u − wish‖² subject to ‖u‖ ≥ 1, with u on the circle.
SecondOrder on_the_circle(const Eigen::Vector2d& wish, const Eigen::Vector2d& u) {
  const ShootingProblem problem =
      testing::one_step({wish[0], wish[1]}, ConstraintKind::norm, {1, testing::kFree});
  const double multiplier = (wish - u).dot(u);
  return at_step(problem, u, multiplier * u, VectorXd::Constant(1, multiplier),
                 0.5 * (u - wish).squaredNorm());
}

TEST(SecondOrder, DistinguishesNearAndFarPointOfADisc) {
  EXPECT_EQ(on_the_circle({0.5, 0}, {1, 0}).curvature, Curvature::positive);
  const SecondOrder far = on_the_circle({0.5, 0}, {-1, 0});
  EXPECT_EQ(far.curvature, Curvature::negative);
  // The Hessian along the circle is 1 − 1.5; the range of the second control is 0.
  ASSERT_EQ(far.direction.size(), 2u);
  EXPECT_NEAR(far.direction[0][2], 0, 1e-12);
  EXPECT_NEAR(std::abs(far.direction[0][3]), 1, 1e-12);
  EXPECT_NEAR(far.bend, -0.25, 1e-12);
  // All points of the circle are equally distant from its center.
  EXPECT_EQ(on_the_circle({0, 0}, {1, 0}).curvature, Curvature::undecided);
}

TEST(SecondOrder, GainMatchesCostDecreaseOfDenseOptimum) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const testing::LinearQuadratic lq(seed, 4, {2, 3}, 6, -testing::kFree, testing::kFree, 0.9);
    SolveResult best = solve(*lq.problem, "ilqr", {}, lq.problem->create_trajectory());
    const double optimum = lq.cost(lq.dense_optimum());
    SolveResult moved = best;
    for (int k = 0; k < lq.N(); ++k) moved.trajectory.u(k).array() += 0.1 * std::sin(1.0 + k);
    Evaluator(*lq.problem).simulate(moved.trajectory);
    const SecondOrder found = at_answer(*lq.problem, moved);
    EXPECT_EQ(found.curvature, Curvature::positive);
    EXPECT_NEAR(found.gain, lq.cost(moved.trajectory) - optimum, 1e-9 * optimum);
    EXPECT_GT(found.share(), 1e-5);
    EXPECT_LT(at_answer(*lq.problem, best).share(), 1e-9);
  }
}

// One control reaches four states in four steps; rows are passed back through stages that
// cannot satisfy them.
TEST(SecondOrder, GoalsArePassedBackToEarlierControls) {
  const testing::LinearQuadratic lq(4, 4, {1}, 8, -testing::kFree, testing::kFree, 0.9);
  const ShootingProblem problem = testing::with_constraints(
      *lq.problem, {testing::goal_constraint(*lq.problem, {1, 0, -1, 0.5})});
  SolveResult result = solve(problem, "altro", {}, problem.create_trajectory());
  ASSERT_EQ(result.status, SolveStatus::converged);
  const double optimum = result.cost;
  const SecondOrder found = at_answer(problem, result);
  EXPECT_EQ(found.curvature, Curvature::positive);
  EXPECT_LT(found.share(), 1e-6);
  // The model is exact: from a missed goal, it leads back to the optimum.
  const double miss = 10;
  Trajectory& at = result.trajectory;
  for (int k = 0; k < problem.knots(); ++k) at.u(k).array() += miss;
  Evaluator(problem).simulate(at);
  const double cost = lq.cost(at);
  const SecondOrder missed = at_answer(problem, result);
  const double apart = std::abs(cost - optimum);
  ASSERT_GT(apart, 1e-5 * optimum);
  EXPECT_NEAR(missed.repair, std::abs(optimum - cost + missed.gain), 1e-4 * apart);
}

/// The system x⁺ = A x + B u on the way to a goal at the cost ½ Σ (‖u‖² + weight ‖x‖²).
ShootingProblem linear_to_goal(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B,
                               const std::vector<double>& start, const std::vector<double>& goal,
                               int knots, double weight = 0) {
  const auto n = static_cast<int>(B.rows()), nu = static_cast<int>(B.cols());
  const auto system = linear_system(A, B, VectorXd::Zero(n));
  const auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_cost("effort", control_residual(n, nu), {});
  running->add_cost("states", state_residual(running->manifold()), {});
  std::vector<double> numbers(nu + n + 2, 0.0);
  numbers[nu] = 1;
  numbers.back() = weight;
  std::vector<Phase> phases;
  phases.push_back({.name = "go",
                    .model = running,
                    .dt = std::vector<double>(knots, 1.0),
                    .cost_scale = std::vector<double>(knots, 1.0)});
  for (int k = 0; k < knots; ++k)
    phases.back().parameters.insert(phases.back().parameters.end(), numbers.begin(), numbers.end());
  const auto end = std::make_shared<KnotModel>(system, Integrator::none);
  const ShootingProblem free(start, std::move(phases),
                             {.name = "end", .model = end, .dt = {0}, .cost_scale = {1}});
  return testing::with_constraints(free, {testing::goal_constraint(free, goal)});
}

/// A chain of integrators, moved by its last derivative.
struct Chain {
  static constexpr double dt = 0.05;
  explicit Chain(int n) : A(Eigen::MatrixXd::Identity(n, n)), B(dt * VectorXd::Unit(n, n - 1)) {
    A.diagonal(1).setConstant(dt);
  }
  Eigen::MatrixXd A, B;
};

// Elimination needs gains of dt⁻ⁿ: its policy reaches the goal in the last n steps.
TEST(SecondOrder, GoalsThatFewStepsHardlyReachAreDecided) {
  constexpr int n = 8, N = 60;
  const Chain chain(n);
  std::vector<double> start(n, 0.0);
  start[0] = 1;
  const ShootingProblem problem =
      linear_to_goal(chain.A, chain.B, start, std::vector<double>(n, 0.0), N);
  const SolveResult result = solve(problem, "ipopt", {}, problem.create_trajectory());
  ASSERT_EQ(result.status, SolveStatus::converged);
  const SecondOrder found = at_answer(problem, result);
  EXPECT_EQ(found.curvature, Curvature::positive);
  EXPECT_LT(found.share(), 1e-6);
}

// States that are the better the farther away they are: the verdict is that of the dense Hessian on
// the null space of the goal, which the last steps hardly reach.
TEST(SecondOrder, VerdictIsThatOfTheDenseReducedHessian) {
  constexpr int n = 6, N = 40;
  const Chain chain(n);
  const auto& [A, B] = chain;
  const VectorXd start = VectorXd::Unit(n, 0);
  // x_k = free_k + by_u_k u
  std::vector<VectorXd> free{start};
  std::vector<Eigen::MatrixXd> by_u{Eigen::MatrixXd::Zero(n, N)};
  for (int k = 0; k < N; ++k) {
    free.push_back(A * free[k]);
    by_u.push_back(A * by_u[k]);
    by_u.back().col(k) += B;
  }
  const Eigen::MatrixXd to_goal = by_u[N];
  const Eigen::MatrixXd Z =
      Eigen::MatrixXd(to_goal.transpose().fullPivHouseholderQr().matrixQ()).rightCols(N - n);
  ASSERT_LT((to_goal * Z).norm(), 1e-12);
  int minima = 0, others = 0;
  for (double weight = -1e-2; weight > -1e3; weight *= 2) {
    Eigen::MatrixXd H = Eigen::MatrixXd::Identity(N, N);
    VectorXd h = VectorXd::Zero(N);
    for (int k = 0; k < N; ++k) {
      H += weight * by_u[k].transpose() * by_u[k];
      h += weight * by_u[k].transpose() * free[k];
    }
    const double least =
        (Z.transpose() * H * Z).selfadjointView<Eigen::Lower>().eigenvalues().minCoeff();
    if (std::abs(least) < 1e-3) continue;
    const VectorXd reached = to_goal.completeOrthogonalDecomposition().solve(-free[N]);
    const VectorXd u =
        reached + Z * (Z.transpose() * H * Z).ldlt().solve(Z.transpose() * (-h - H * reached));
    const ShootingProblem problem = linear_to_goal(A, B, {start.data(), start.data() + n},
                                                   std::vector<double>(n, 0.0), N, weight);
    SolutionClaims claims(problem);
    claims.times = problem.times();
    claims.converged = true;
    claims.status = "converged";
    claims.multipliers = to_goal.transpose().completeOrthogonalDecomposition().solve(-(H * u + h));
    for (int k = 0; k <= N; ++k) {
      claims.trajectory.x(k) = free[k] + by_u[k] * u;
      if (k < N) claims.trajectory.u(k) = u.segment(k, 1);
    }
    claims.costates.col(N) = claims.multipliers;
    for (int k = N - 1; k >= 0; --k)
      claims.costates.col(k) =
          A.transpose() * claims.costates.col(k + 1) + weight * claims.trajectory.x(k);
    const Curvature found = certify(problem, claims).second_order->curvature;
    EXPECT_EQ(found == Curvature::positive, least > 0) << weight << ": " << least;
    ++(least > 0 ? minima : others);
  }
  EXPECT_GE(minima, 3);
  EXPECT_GE(others, 3);
}

// The second row of the goal is the first one but for `reach` of the second control, and both
// disagree by 1e-9.
TEST(SecondOrder, NamesEquationThatFollowsFromOthers) {
  const auto at_goal = [](double reach) {
    Eigen::Matrix2d B;
    B << 1, 0, 1, reach;
    const ShootingProblem problem =
        linear_to_goal(Eigen::Matrix2d::Identity(), B, {0, 0}, {1, 1 + 1e-9}, 1);
    SolutionClaims claims =
        testing::claims_of(problem, Eigen::Vector2d(1, 0), Eigen::Vector2d(-1, 0), 0.5);
    claims.trajectory.x(1) = Eigen::Vector2d(1, 1);
    return *certify(problem, claims).second_order;
  };
  EXPECT_EQ(at_goal(3e-8).doubtful, "goal");
  EXPECT_GT(at_goal(3e-8).share(), 1e-4);
  EXPECT_EQ(at_goal(1).doubtful, "");
}

TEST(SecondOrder, FiguresFollowTheUnitOfTheCost) {
  for (const double unit : {0x1p-40, 1.0, 0x1p40}) {
    const ShootingProblem problem =
        testing::one_step({1}, ConstraintKind::bounds, {0.5, 0.5}, 0, unit);
    const SecondOrder found =
        at_step(problem, VectorXd::Constant(1, 0.5), VectorXd::Constant(1, 0.5 * unit),
                VectorXd::Constant(1, 0.5 * unit), 0.125 * unit);
    EXPECT_EQ(found.curvature, Curvature::positive);
    EXPECT_NEAR(found.cost_size / unit, 0.125, 1e-12);
    EXPECT_LT(found.share(), 1e-12);
  }
}

// A goal below the constraint tolerance, at rest: a step towards it remains.
TEST(SecondOrder, GoalBelowItsToleranceIsNoAnswer) {
  const ShootingProblem problem = testing::one_step({0}, ConstraintKind::bounds, {5e-7, 5e-7});
  const VectorXd zero = VectorXd::Zero(1);
  SolutionClaims claims = testing::claims_of(problem, zero, zero, 0);
  claims.constraint = 5e-7;
  const Certificate found = certify(problem, claims);
  EXPECT_EQ(found.verdict(), Verdict::contradicted);
  EXPECT_TRUE(found.optimality_in_doubt);
  EXPECT_NEAR(found.second_order->repair, 0.5 * 5e-7 * 5e-7, 1e-20);
}

// An interior point leaves a small multiplier at every bound.
TEST(SecondOrder, IgnoresMultipliersFarFromTheirBounds) {
  const ShootingProblem problem =
      testing::one_step({0.3, 5}, ConstraintKind::bounds, {-5, -5, 1, 1});
  const double left = 1e-5;
  const Eigen::Vector2d u(0.3 - left, 1), multiplier(left, 4);
  const SecondOrder found = at_step(problem, u, multiplier, multiplier, 8);
  EXPECT_EQ(found.curvature, Curvature::positive);
  EXPECT_LT(found.share(), 1e-10) << "of the way to the bound 0.03";
  // A multiplier as large as all cost gradients is a false claim.
  const Eigen::Vector2d off(-0.7, 1), pushed(1, 4);
  const SecondOrder claimed = at_step(problem, off, pushed, pushed, 8.5);
  EXPECT_GT(claimed.share(), 1e-2);
}

// The cost falls along a control without curvature until a bound stops it.
TEST(SecondOrder, FlatDirectionsCountByTheirSlope) {
  const auto system = linear_system(Eigen::MatrixXd::Identity(1, 1),
                                    Eigen::MatrixXd::Identity(1, 1), VectorXd::Zero(1));
  auto running = std::make_shared<KnotModel>(system, Integrator::discrete);
  running->add_cost("effort", control_residual(1, 1), {.kind = ActivationKind::linear});
  running->set_control_bounds({-3}, {3});
  std::vector<Phase> phases;
  phases.push_back(
      {.name = "go", .model = running, .dt = {1}, .cost_scale = {1}, .parameters = {0.0, 1.0}});
  const ShootingProblem problem(std::vector<double>{0}, std::move(phases),
                                {.name = "end",
                                 .model = std::make_shared<KnotModel>(system, Integrator::none),
                                 .dt = {0},
                                 .cost_scale = {1}});
  const SecondOrder found =
      at_step(problem, VectorXd::Constant(1, 2), VectorXd::Zero(1), VectorXd(), 2);
  EXPECT_EQ(found.curvature, Curvature::undecided);
  EXPECT_NEAR(found.gain, 2, 1e-12) << "a range, which ends before the bound";
}

TEST(SecondOrder, OnlyConvergedAnswersAreJudged) {
  const ShootingProblem problem = testing::pendulum_swing_up();
  const SolveResult early =
      solve(problem, "box_fddp", {.max_iterations = 1}, problem.create_trajectory());
  ASSERT_EQ(early.status, SolveStatus::max_iterations);
  const NodeValues values(problem, early.trajectory);
  const Certificate found = certify(problem, claims_of(problem, early, values, {}), values);
  EXPECT_FALSE(found.second_order);
  EXPECT_EQ(found.verdict(), Verdict::consistent);
}

}  // namespace
}  // namespace conddp
