#include "solvers/augmented_lagrangian.hpp"

#include <gtest/gtest.h>

#include "ocp/acts.hpp"
#include "support/conic_problems.hpp"

namespace conddp::testing {
namespace {

// Boxes and cones that no row touches, and then one that a row does.
TEST(AugmentedLagrangian, IsIdleWhereAllRowsAreStrictlyInside) {
  ConicSize size = middle_size();
  size.equalities = size.terminal = 0;
  size.boxes = 1;
  const ConicLinearQuadratic conic(1, size);
  const ShootingProblem& problem = *conic.problem;
  AugmentedLagrangian constraints(problem, {}, MultiplierSchedule::always);
  Eigen::VectorXd inside(problem.constraint_rows());
  for (const NodeConstraint& c : problem.constraints()) {
    auto g = inside.segment(c.row, c.term->rows);
    g.setZero();
    if (c.term->has_bounds())
      g[0] = 0.5 * (c.lower[0] + c.upper[0]);
    else
      g[c.term->rows - 1] = 1;
  }
  EXPECT_TRUE(constraints.idle(inside));
  EXPECT_EQ(constraints.measure(inside).violation.value, 0);
  EXPECT_TRUE(constraints.multipliers().isZero(0));

  for (const NodeConstraint& c : problem.constraints()) {
    Eigen::VectorXd touching = inside;
    touching[c.row] = c.term->has_bounds() ? c.upper[0] : 1;
    EXPECT_FALSE(constraints.idle(touching));
  }
  constraints.start(Eigen::VectorXd::Ones(problem.constraint_rows()));
  EXPECT_FALSE(constraints.idle(inside));  // multipliers that are still to go
}

// Their curvature is there where their values vanish, and changes with the penalty.
TEST(AugmentedLagrangian, EqualitiesAreNeverIdle) {
  ConicSize size = middle_size();
  size.boxes = size.cones = 0;
  const ConicLinearQuadratic conic(1, size);
  AugmentedLagrangian constraints(*conic.problem, {}, MultiplierSchedule::always);
  EXPECT_FALSE(constraints.idle(Eigen::VectorXd::Zero(conic.problem->constraint_rows())));
}

}  // namespace
}  // namespace conddp::testing
