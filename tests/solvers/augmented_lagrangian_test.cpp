#include "solvers/constraints/augmented_lagrangian.hpp"

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "support/conic_problems.hpp"
#include "support/dense_horizon.hpp"

namespace conddp::testing {
namespace {

// Inactive boxes and cones, and then an active one.
TEST(AugmentedLagrangian, IsIdleIfAllRowsAreStrictlyInside) {
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
    // The effect of a violation vanishes once all rows hold again.
    touching[c.row] += 1;
    EXPECT_GT(constraints.measure(touching).dual_gain, 0);
    EXPECT_FALSE(constraints.multipliers().isZero(0));
    EXPECT_EQ(constraints.measure(inside).dual_gain, 0);
    EXPECT_TRUE(constraints.multipliers().isZero(0));
  }
  constraints.start(Eigen::VectorXd::Ones(problem.constraint_rows()));
  EXPECT_FALSE(constraints.idle(inside));  // multipliers that must still vanish
  EXPECT_GT(constraints.measure(inside).dual_gain, 0);
}

// Equalities have curvature even where their values vanish, and it changes with the penalty.
TEST(AugmentedLagrangian, EqualitiesAreNeverIdle) {
  ConicSize size = middle_size();
  size.boxes = size.cones = 0;
  const ConicLinearQuadratic conic(1, size);
  AugmentedLagrangian constraints(*conic.problem, {}, MultiplierSchedule::always);
  EXPECT_FALSE(constraints.idle(Eigen::VectorXd::Zero(conic.problem->constraint_rows())));
}

class Schedules : public ::testing::TestWithParam<MultiplierSchedule> {};

// A violation at a point that is not a minimum raises no penalty.
TEST_P(Schedules, RaiseNoPenaltyWithoutAMinimum) {
  ConicSize size = middle_size();
  size.boxes = size.cones = 0;
  const ConicLinearQuadratic conic(1, size);
  AugmentedLagrangian constraints(*conic.problem, {}, GetParam());
  const double first = constraints.largest_penalty();
  Eigen::VectorXd bounds = Eigen::VectorXd::Zero(conic.problem->constraint_rows());
  int rows = 0;  // of constraints present at their nodes
  for (const NodeConstraint& c : conic.problem->constraints())
    for (int r = 0; r < c.term->rows; ++r, ++rows) bounds[c.row + r] = c.lower[r];
  // A row with an error of 1 contributes |ν⁺ − ν|² / ρ = ρ.
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

/// Two "equal" rows at the first node and one at the second, with bounds 0.5; a soft row in ± 1 at
/// the end with multiplier limit 2.
struct NamedRows {
  static constexpr double kLimit = 2;
  NamedRows() : lq(1, 2, {3, 2}, 1, -1, 1) {
    const ShootingProblem& free = *lq.problem;
    const auto ones = [](int rows, int columns) -> Eigen::MatrixXd {
      return Eigen::MatrixXd::Ones(rows, columns);
    };
    Added first = affine_rows(ones(2, 5), free, 0, 0, 0.5, 0.5);
    Added second = affine_rows(ones(1, 4), free, 1, 1, 0.5, 0.5);
    Added soft = affine_rows(ones(1, 2), free, 2, 2, -1, 1);
    first.name = second.name = "equal";
    soft.softness = Softness::l1;
    soft.weight = kLimit;
    problem = std::make_unique<ShootingProblem>(with_constraints(free, {first, second, soft}));
    EXPECT_EQ(problem->constraint_rows(), 4);
  }
  LinearQuadratic lq;
  std::unique_ptr<ShootingProblem> problem;
};

SolverOptions schedule_options() {
  SolverOptions options;
  options.augmented_lagrangian = {
      .initial_penalty = 4, .penalty_factor = 10, .max_penalty = 4000, .sufficient_decrease = 0.25};
  options.tolerances.constraint = 1e-6;
  return options;
}

constexpr auto kAlways = MultiplierSchedule::always;
constexpr auto kBound = MultiplierSchedule::bound_constrained_lagrangian;

// With ρ = 4: ν + ρ (g − 0.5) for equalities; for the soft row ν + ρ (|g| − 1) beyond 1, limited to
// 2.
TEST(AugmentedLagrangian, MultipliersComeFromShiftedDistances) {
  const NamedRows rows;
  AugmentedLagrangian constraints(*rows.problem, schedule_options(), kAlways);
  constraints.start(Eigen::Vector4d(1, -2, 3, 0.5));
  EXPECT_EQ(constraints.augmentation().penalty, Eigen::Vector4d::Constant(4));
  EXPECT_EQ(constraints.augmentation().shift, Eigen::Vector4d(0.25, -0.5, 0.75, 0.125));
  const ConstraintNorms norms = constraints.measure(Eigen::Vector4d(0.75, 0, 0.625, -1.25));
  EXPECT_EQ(constraints.multipliers(), Eigen::Vector4d(2, -4, 3.5, -0.5));
  EXPECT_EQ(norms.violation.value, 0.5);
  EXPECT_EQ(norms.violation.knot, 0);
  EXPECT_EQ(norms.dual_gain, (1 + 4 + 0.25 + 1) / 4.);
  // The soft row is 0.25 beyond −1 and its multiplier is 1.5 below its limit.
  EXPECT_EQ(norms.complementarity, 0.25 * 1.5);
  EXPECT_EQ(constraints.measure(Eigen::Vector4d(0.5, 0.5, -0.5, 3)).violation.knot, 1);
  EXPECT_EQ(constraints.multipliers()[3], NamedRows::kLimit);
}

TEST(AugmentedLagrangian, PenaltiesGrowIfViolationFallsTooSlowly) {
  const NamedRows rows;
  AugmentedLagrangian constraints(*rows.problem, schedule_options(), kAlways);
  const auto minimized_at = [&](double first, double second) {
    constraints.measure(Eigen::Vector4d(0.5 + first, 0.5, 0.5 + second, 0));
    constraints.update();
    return constraints.augmentation().penalty;
  };
  EXPECT_EQ(minimized_at(1, 0.5), Eigen::Vector4d::Constant(4)) << "nothing is known before";
  EXPECT_EQ(constraints.augmentation().shift, Eigen::Vector4d(1, 0, 0.5, 0)) << "ν⁺ is taken";
  EXPECT_EQ(minimized_at(0.125, -0.25), Eigen::Vector4d::Constant(4)) << "a quarter";
  EXPECT_EQ(minimized_at(0.125, 0), Eigen::Vector4d(40, 40, 40, 4)) << "half";
  EXPECT_EQ(constraints.augmentation().shift[0], (4 * (1 + 0.125 + 0.125)) / 40);
  EXPECT_EQ(minimized_at(0.125, 0), Eigen::Vector4d(400, 400, 400, 4));
  EXPECT_EQ(minimized_at(0.125, 0), Eigen::Vector4d(4000, 4000, 4000, 4));
  EXPECT_EQ(minimized_at(0.125, 0), Eigen::Vector4d(4000, 4000, 4000, 4)) << "the most";
  EXPECT_EQ(constraints.largest_penalty(), 4000);
  EXPECT_TRUE(constraints.may_relax());
  constraints.relax();
  EXPECT_EQ(constraints.augmentation().penalty, Eigen::Vector4d(400, 400, 400, 4));
  for (int i = 0; i < 3; ++i) constraints.relax();
  EXPECT_EQ(constraints.augmentation().penalty, Eigen::Vector4d::Constant(4));
  EXPECT_FALSE(constraints.may_relax());
}

// Violations below a tenth of the tolerance, or already within tolerance before, need no larger
// penalty.
TEST(AugmentedLagrangian, PenaltiesDoNotGrowForSatisfiedConstraints) {
  const NamedRows rows;
  for (const auto& [before, now, grows] :
       {std::tuple{1e-5, 0.9e-7, false}, {2e-7, 1.1e-7, false}, {1.1e-6, 9e-7, true}}) {
    AugmentedLagrangian constraints(*rows.problem, schedule_options(), kAlways);
    for (const double off : {before, now}) {
      constraints.measure(Eigen::Vector4d(0.5, 0.5 - off, 0.5, 0));
      constraints.update();
    }
    EXPECT_EQ(constraints.largest_penalty() > 4, grows) << before << ' ' << now;
  }
}

// Soft rows only need their requested multiplier change to fall to 0.7.
TEST(AugmentedLagrangian, SoftPenaltiesGrowWithTheChangeOfMultipliers) {
  const NamedRows rows;
  for (const double share : {0.2, 0.3}) {
    AugmentedLagrangian constraints(*rows.problem, schedule_options(), kAlways);
    double sum = 0;
    for (const double change : {0.25, 0.25 * share}) {
      // ν⁺ − ν = ρ · change for this distance beyond 1.
      constraints.measure(Eigen::Vector4d(0.5, 0.5, 0.5, 1 + change));
      constraints.update();
      sum += change;
    }
    EXPECT_NEAR(constraints.augmentation().shift[3] * constraints.augmentation().penalty[3],
                std::min(4 * sum, NamedRows::kLimit), 1e-14);
    EXPECT_EQ(constraints.augmentation().penalty[3], share > 0.25 ? 40 : 4) << share;
  }
}

// Multipliers change if the violation is at most a tenth of the last change; otherwise penalties
// grow.
TEST(AugmentedLagrangian, BoundConstrainedScheduleUpdatesMultipliersOrPenalty) {
  const NamedRows rows;
  AugmentedLagrangian constraints(*rows.problem, schedule_options(), kBound);
  const auto minimized_at = [&](double off) {
    constraints.measure(Eigen::Vector4d(0.5 + off, 0.5, 0.5, 0));
    constraints.update();
    return constraints.augmentation().penalty[0];
  };
  const auto multiplier = [&] {
    return constraints.augmentation().shift[0] * constraints.augmentation().penalty[0];
  };
  EXPECT_EQ(minimized_at(1), 4);
  EXPECT_NEAR(multiplier(), 4, 1e-14);
  EXPECT_EQ(minimized_at(0.125), 40) << "more than 0.1";
  EXPECT_NEAR(multiplier(), 4, 1e-14) << "stays";
  EXPECT_EQ(minimized_at(0.0625), 40);
  EXPECT_NEAR(multiplier(), 4 + 40 * 0.0625, 1e-14);
  EXPECT_EQ(minimized_at(0.0625), 400) << "more than a tenth of that";
}

TEST(AugmentedLagrangian, ReportsConstraintAfterSixUselessPenalties) {
  const NamedRows rows;
  SolverOptions options = schedule_options();
  options.augmented_lagrangian.max_penalty = 4e10;
  for (const double violation : {1e-4, 9e-6}) {
    AugmentedLagrangian constraints(*rows.problem, options, kAlways);
    int updates = 0;
    while (constraints.stalled().empty() && updates < 20) {
      constraints.measure(Eigen::Vector4d(0.5, 0.5, 0.5 - violation, 0));
      constraints.update();
      ++updates;
    }
    // Below 1e-5, it is rounding. The first update sets the reference; the penalty grows in all
    // later updates.
    EXPECT_EQ(updates, violation > 1e-5 ? 7 : 20);
    EXPECT_EQ(constraints.stalled(), violation > 1e-5 ? "equal" : "");
  }
}

TEST(AugmentedLagrangian, HalvingViolationIsNotStalled) {
  const NamedRows rows;
  AugmentedLagrangian constraints(*rows.problem, schedule_options(), kAlways);
  double violation = 1;
  for (int i = 0; i < 12; ++i, violation *= i % 5 == 0 ? 0.5 : 1) {
    constraints.measure(Eigen::Vector4d(0.5, 0.5, 0.5 - violation, 0));
    constraints.update();
    EXPECT_EQ(constraints.stalled(), "") << i;
  }
}

// Ten times the distance to the further bound: 10 (0.5 + 1) ρ ≤ 2.
TEST(AugmentedLagrangian, FirstSoftPenaltiesFitTheirLimits) {
  const NamedRows rows;
  AugmentedLagrangian constraints(*rows.problem, schedule_options(), kAlways);
  EXPECT_TRUE(constraints.fit_soft(Eigen::Vector4d(7, 7, 7, 0.5)));
  EXPECT_NEAR(constraints.augmentation().penalty[3], 2 / 15., 1e-16);
  EXPECT_EQ(constraints.augmentation().penalty[0], 4);
  EXPECT_FALSE(constraints.fit_soft(Eigen::Vector4d(7, 7, 7, -0.5))) << "as far";
  EXPECT_FALSE(constraints.may_relax());
}

// Rows in [−1, 1] and [−4, 2] with multiplier limit 2.
TEST(AugmentedLagrangian, FirstSoftPenaltiesFitTheFurthestBound) {
  const LinearQuadratic lq(1, 2, {3, 2}, 1, -1, 1);
  Added soft = affine_rows(Eigen::MatrixXd::Ones(2, 2), *lq.problem, 2, 2, -1, 1);
  soft.lower = {-1, -4};
  soft.upper = {1, 2};
  soft.softness = Softness::l1;
  soft.weight = 2;
  const ShootingProblem problem = with_constraints(*lq.problem, {soft});
  for (const auto& [first, second, furthest] :
       {std::tuple{0.5, 1.0, 5.0}, {7.0, -1.0, 8.0}, {-7.0, -1.0, 8.0}, {0.0, -9.0, 11.0}}) {
    AugmentedLagrangian constraints(problem, schedule_options(), kAlways);
    EXPECT_TRUE(constraints.fit_soft(Eigen::Vector2d(first, second)));
    EXPECT_NEAR(constraints.augmentation().penalty[0], 2 / (10 * furthest), 1e-15) << furthest;
  }
}

TEST(AugmentedLagrangian, AdoptedOrAddedMultipliersKeepPenalties) {
  const NamedRows rows;
  AugmentedLagrangian constraints(*rows.problem, schedule_options(), kAlways);
  constraints.adopt(Eigen::Vector4d(1, 2, 3, 1));
  EXPECT_EQ(constraints.augmentation().shift, Eigen::Vector4d(0.25, 0.5, 0.75, 0.25));
  EXPECT_EQ(constraints.multipliers(), Eigen::Vector4d(1, 2, 3, 1));
  constraints.add(Eigen::Vector4d(2, -2, 0, 1), 0.5);
  EXPECT_EQ(constraints.augmentation().shift, Eigen::Vector4d(0.5, 0.25, 0.75, 0.375));
  EXPECT_EQ(constraints.augmentation().penalty, Eigen::Vector4d::Constant(4));
}

TEST(AugmentedLagrangian, IsIdleOnlyUpToTheBounds) {
  const LinearQuadratic lq(1, 2, {3, 2}, 1, -1, 1);
  const ShootingProblem problem = with_constraints(
      *lq.problem, {affine_rows(Eigen::MatrixXd::Ones(2, 2), *lq.problem, 2, 2, -1, 3)});
  AugmentedLagrangian constraints(problem, schedule_options(), kAlways);
  constraints.start(Eigen::Vector2d(4, -4));  // shifted by ± 1
  EXPECT_TRUE(constraints.idle(Eigen::Vector2d(1.9, 0.1)));
  EXPECT_FALSE(constraints.idle(Eigen::Vector2d(2, 0.1)));
  EXPECT_FALSE(constraints.idle(Eigen::Vector2d(1.9, 0)));
  EXPECT_FALSE(constraints.idle(Eigen::Vector2d(-2, 1)));
  EXPECT_FALSE(constraints.idle(Eigen::Vector2d(0, 4)));
}

}  // namespace
}  // namespace conddp::testing
