#include "solvers/globalization/affine_probe.hpp"

#include <gtest/gtest.h>

#include "support/conic_problems.hpp"
#include "support/expression_systems.hpp"

namespace conddp::testing {
namespace {

bool is_affine(const ShootingProblem& problem, const Trajectory& trajectory) {
  Evaluator evaluator(problem);
  Linearization linearization(problem);
  evaluator.differentiate(trajectory, linearization);
  return AffineProbe(problem).holds(evaluator, trajectory, linearization);
}

/// The problem with an additional constraint on the norm of the state at one node.
ShootingProblem with_norm(const ShootingProblem& problem, int node) {
  return with_constraints(problem, {{.name = "norm",
                                     .residual = state_residual(problem.manifold()),
                                     .kind = ConstraintKind::norm,
                                     .reference = std::vector<double>(problem.nx(), 0.1),
                                     .lower = {0},
                                     .upper = {1},
                                     .first = node,
                                     .last = node}});
}

TEST(AffineProbe, HoldsForAffineModelsAtAnyIterate) {
  const ConicLinearQuadratic conic(
      1, {.nx = 5, .nu = 3, .knots = 6, .equalities = 1, .boxes = 2, .cones = 1, .terminal = 2});
  EXPECT_TRUE(is_affine(*conic.problem, conic.problem->create_trajectory()));
  EXPECT_TRUE(is_affine(*conic.problem, random_guess(*conic.problem, 3, 100)));
  const LinearQuadratic lq(2, 4, {2, 3}, 4, -1, 1);
  EXPECT_TRUE(is_affine(*lq.problem, random_guess(*lq.problem, 4)));
}

TEST(AffineProbe, DetectsOneCurvedRowOfOneNode) {
  const LinearQuadratic lq(2, 4, {2, 3}, 4, -1, 1);
  for (const int node : {1, 4, lq.N()}) {
    const ShootingProblem problem = with_norm(*lq.problem, node);
    EXPECT_FALSE(is_affine(problem, random_guess(problem, 4))) << node;
  }
}

TEST(AffineProbe, DetectsDynamicsCurvedInOneComponent) {
  const ShootingProblem swing_up = pendulum_swing_up();
  EXPECT_FALSE(is_affine(swing_up, random_guess(swing_up, 1)));
  // Only the two positions of the cart have curved dynamics.
  const ShootingProblem parking = unicycle_parking();
  EXPECT_FALSE(is_affine(parking, random_guess(parking, 1)));
}

// The square of a control moves one of two states.
TEST(AffineProbe, DetectsAnyCurvedState) {
  for (const bool first : {true, false}) {
    const auto system = expression_system(
        {.kind = SystemKind::first_order,
         .states = {{"x"}, {"y"}},
         .controls = {{"u", "1"}},
         .equations = {{"x", first ? "u^2 - x" : "u - x"}, {"y", first ? "u - y" : "u^2 - y"}}});
    const ShootingProblem problem =
        tracking_problem(system, Integrator::rk4, 3, 0.1, {0, 0}, {{1, 1}, {1, 1}, {1}, {1, 1}});
    EXPECT_FALSE(is_affine(problem, random_guess(problem, 1))) << first;
  }
}

TEST(AffineProbe, FailsIfANumberIsMissing) {
  const LinearQuadratic lq(2, 4, {2, 3}, 4, -1, 1);
  for (const int k : {1, 4, lq.N()}) {
    Trajectory bad = random_guess(*lq.problem, 4);
    bad.x(k)[k % 2 == 0 ? 3 : 0] = std::numeric_limits<double>::quiet_NaN();
    EXPECT_FALSE(is_affine(*lq.problem, bad)) << k;
  }
}

}  // namespace
}  // namespace conddp::testing
