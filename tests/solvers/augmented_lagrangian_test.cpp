#include "solvers/constraints/augmented_lagrangian.hpp"

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
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

class Schedules : public ::testing::TestWithParam<MultiplierSchedule> {};

// What is violated at a point that is no minimum speaks against no penalty.
TEST_P(Schedules, RaiseNoPenaltyWhereNothingWasMinimized) {
  ConicSize size = middle_size();
  size.boxes = size.cones = 0;
  const ConicLinearQuadratic conic(1, size);
  AugmentedLagrangian constraints(*conic.problem, {}, GetParam());
  const double first = constraints.largest_penalty();
  Eigen::VectorXd bounds = Eigen::VectorXd::Zero(conic.problem->constraint_rows());
  int rows = 0;  // of constraints that are there at their nodes
  for (const NodeConstraint& c : conic.problem->constraints())
    for (int r = 0; r < c.term->rows; ++r, ++rows) bounds[c.row + r] = c.lower[r];
  // A row that is 1 off asks for |ν⁺ − ν|² / ρ = ρ.
  double off = 1;
  const auto values = [&] { return Eigen::VectorXd(bounds.array() + off); };
  EXPECT_NEAR(constraints.measure(values()).dual_gain, first * rows, 1e-12);
  constraints.update();
  for (const bool minimized : {false, false, true}) {
    off *= 1.5;
    constraints.measure(values());
    EXPECT_EQ(constraints.largest_penalty(), first);
    constraints.update(minimized);
  }
  EXPECT_GT(constraints.largest_penalty(), first);
}

INSTANTIATE_TEST_SUITE_P(AugmentedLagrangian, Schedules,
                         ::testing::Values(MultiplierSchedule::always,
                                           MultiplierSchedule::bound_constrained_lagrangian));

}  // namespace
}  // namespace conddp::testing
