#include "solvers/iterate/iterate.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "support/plain_pendulum.hpp"

namespace conddp::testing {
namespace {

/// A pendulum iterate with constant controls and inconsistent states.
struct Standing {
  explicit Standing(const DdpRecipe& given = {})
      : recipe(given),
        problem(plain.problem()),
        bounds(problem),
        evaluator(problem),
        record(problem, options, false),
        iterate(problem, bounds, evaluator, recipe, options, record) {
    record.begin();
    iterate.reset();
    iterate.trajectory = constant_controls(problem, 1.5);
    for (int k = 1; k <= 5; ++k) iterate.trajectory.x(k) += Eigen::Vector2d(0.1 * k, -0.2);
  }
  /// Costates without gains.
  std::vector<Eigen::Vector2d> costates() const {
    std::vector<Eigen::Vector2d> lambda(6);
    lambda[5] = plain.end_gradient(iterate.trajectory.x(5));
    for (int k = 4; k >= 0; --k) {
      const Eigen::Vector2d x = iterate.trajectory.x(k);
      lambda[k] = plain.stage_gradient(x, 1.5).head<2>() +
                  plain.jacobian(x).leftCols<2>().transpose() * lambda[k + 1];
    }
    return lambda;
  }

  PlainPendulum plain;
  DdpRecipe recipe;
  SolverOptions options;
  ShootingProblem problem;
  ControlBounds bounds;
  Evaluator evaluator;
  SolveRecord record;
  Iterate iterate;
};

TEST(Iterate, DifferentiatingGivesDerivativesCostatesAndResiduals) {
  Standing at({.open_gaps = true});
  at.iterate.differentiate(Feedback(at.problem), nullptr);
  EXPECT_TRUE(at.iterate.linearized);
  const auto lambda = at.costates();
  double stationarity = 0, gap = 0;
  int stationarity_knot = -1, gap_knot = -1;
  for (int k = 0; k < 5; ++k) {
    const Eigen::Vector2d x = at.iterate.trajectory.x(k);
    EXPECT_LT((at.iterate.adjoint.costates().col(k) - lambda[k]).norm(), 1e-12) << k;
    const double gradient = std::abs(at.plain.stage_gradient(x, 1.5)[2] +
                                     at.plain.jacobian(x).col(2).dot(lambda[k + 1]));
    if (gradient > stationarity) {
      stationarity = gradient;
      stationarity_knot = k;
    }
    const double here =
        (at.plain.next<double>(x, 1.5) - at.iterate.trajectory.x(k + 1)).lpNorm<Eigen::Infinity>();
    if (here > gap) {
      gap = here;
      gap_knot = k;
    }
  }
  IterationRecord row;
  at.iterate.describe(row);
  EXPECT_NEAR(row.stationarity, stationarity, 1e-12);
  EXPECT_EQ(row.stationarity_knot, stationarity_knot);
  EXPECT_NEAR(row.gap, gap, 1e-14);
  EXPECT_EQ(row.gap_knot, gap_knot);
  EXPECT_GT(at.record.result.times.differentiate, 0);
}

TEST(Iterate, LargestGapHasItsKnot) {
  Standing at;
  at.iterate.linearization.gap.setZero();
  EXPECT_EQ(at.iterate.largest_gap().value, 0);
  EXPECT_EQ(at.iterate.largest_gap().knot, -1);
  at.iterate.linearization.gap(0, 1) = 2;
  at.iterate.linearization.gap(1, 3) = -3;
  EXPECT_EQ(at.iterate.largest_gap().value, 3);
  EXPECT_EQ(at.iterate.largest_gap().knot, 3);
}

// Derivatives that a full step has computed are kept; missing ones are added.
TEST(Iterate, KeepsExistingDerivatives) {
  Standing at;
  at.iterate.differentiate(Feedback(at.problem), nullptr);
  at.iterate.linearization.knots[5].gradient << 7, 8;
  at.iterate.differentiated = true;
  at.iterate.differentiate(Feedback(at.problem), nullptr);
  EXPECT_EQ(at.iterate.adjoint.costates().col(5), Eigen::Vector2d(7, 8));
  EXPECT_FALSE(at.iterate.differentiated);
  at.iterate.differentiate(Feedback(at.problem), nullptr);
  EXPECT_EQ(at.iterate.linearization.knots[5].gradient,
            at.plain.end_gradient(at.iterate.trajectory.x(5)));
}

TEST(Iterate, ExactHessiansWaitUntilOpenGapsAreSmall) {
  for (const bool open : {false, true}) {
    Standing at({.open_gaps = open, .hessian = HessianUse::exact});
    const auto theta_theta = [&](int k) {
      return at.iterate.linearization.knots[k].hessian()(0, 0);
    };
    at.iterate.differentiate(Feedback(at.problem), nullptr);
    EXPECT_EQ(at.iterate.gaps.closed(), !open);
    EXPECT_EQ(at.iterate.hessian.exact_known(), !open) << "closed gaps are none";
    at.iterate.exact_below = 1;
    at.iterate.differentiate(Feedback(at.problem), nullptr);
    ASSERT_TRUE(at.iterate.hessian.exact_known());
    const auto lambda = at.costates();
    for (int k = 0; k < 5; ++k) {
      at.iterate.hessian.use(false);
      EXPECT_NEAR(theta_theta(k), 0.15, 1e-15) << k;
      at.iterate.hessian.use(true);
      EXPECT_NEAR(theta_theta(k),
                  0.15 + at.plain.curvature(at.iterate.trajectory.x(k), lambda[k + 1]), 1e-12)
          << k;
    }
  }
}

TEST(Iterate, ExactHessiansExistWithOpenGaps) {
  Standing at({.open_gaps = true, .hessian = HessianUse::exact_alone});
  at.iterate.differentiate(Feedback(at.problem), nullptr);
  EXPECT_FALSE(at.iterate.gaps.closed());
  EXPECT_TRUE(at.iterate.hessian.exact_known());
}

TEST(Iterate, NonFiniteValuesEndAtThePreviousIterate) {
  for (const bool first : {false, true}) {
    Standing at;
    at.iterate.differentiate(Feedback(at.problem), nullptr);
    at.iterate.before = constant_controls(at.problem, -2);
    if (!first) {
      at.record.row.iteration = 3;
      at.record.log_row();
      at.record.row.iteration = 4;
    }
    at.iterate.linearization.cost[3] = std::numeric_limits<double>::quiet_NaN();
    at.iterate.differentiated = true;
    at.iterate.differentiate(Feedback(at.problem), nullptr);
    EXPECT_FALSE(at.iterate.linearized);
    EXPECT_FALSE(at.iterate.end_diverged());
    const SolveResult& result = at.record.result;
    EXPECT_EQ(result.status, SolveStatus::diverged);
    EXPECT_EQ(result.failed_knot, 3);
    EXPECT_EQ(result.failed_quantity, "cost");
    EXPECT_EQ(result.message,
              first ? "the cost of knot 3 is not finite at the start"
                    : "the cost of knot 3 is not finite after the last step, which is undone");
    EXPECT_EQ(at.iterate.trajectory.u(0)[0], first ? 1.5 : -2);
    EXPECT_EQ(at.record.row.iteration, first ? 0 : 3) << "the step does not count";
  }
}

}  // namespace
}  // namespace conddp::testing
