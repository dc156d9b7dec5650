#include "solvers/constraints/row_side.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A row with bounds, soft if it has a limit.
struct Bounds {
  Bounds(double from, double to, double most = kInfinity) : lower(from), upper(to), limit(most) {
    term.rows = 1;
    term.kind = ConstraintKind::bounds;
    if (std::isfinite(limit)) term.softness = Softness::l1;
  }
  NodeConstraint constraint() const { return {0, &term, 0, &lower, &upper, limit}; }

  ConstraintTerm term;
  double lower, upper, limit;
};

/// ‖(v₁, v₂)‖ ≤ t, soft if it has a limit.
struct Cone {
  explicit Cone(double most = kInfinity) : limit(most) {
    term.rows = 3;
    term.kind = ConstraintKind::second_order_cone;
    if (std::isfinite(limit)) term.softness = Softness::l1;
  }
  NodeConstraint constraint() const { return {0, &term, 0, nullptr, nullptr, limit}; }

  ConstraintTerm term;
  double limit;
};

TEST(RowSide, BoundSideFollowsShiftedValue) {
  const Bounds row(-1, 2);
  const NodeConstraint c = row.constraint();
  EXPECT_EQ(chosen_bound(c, 0, 0, 0, 10), RowSide::inactive);
  EXPECT_EQ(chosen_bound(c, 0, 2, 0, 10), RowSide::inactive);
  EXPECT_EQ(chosen_bound(c, 0, 2, 0.1, 10), RowSide::upper);
  EXPECT_EQ(chosen_bound(c, 0, 1.5, 4, 10), RowSide::inactive);
  EXPECT_EQ(chosen_bound(c, 0, 1.5, 6, 10), RowSide::upper);
  EXPECT_EQ(chosen_bound(c, 0, -0.5, -6, 10), RowSide::lower);
}

TEST(RowSide, EqualityIsActiveForAnyMultiplier) {
  const Bounds row(1, 1);
  for (const double multiplier : {-5.0, 0.0, 5.0})
    EXPECT_EQ(chosen_bound(row.constraint(), 0, 1, multiplier, 10), RowSide::equality);
  EXPECT_EQ(revised_bound(row.constraint(), 0, RowSide::equality, 1, -3), RowSide::equality);
}

TEST(RowSide, SoftBoundIsExceededAtItsMultiplierLimit) {
  const Bounds row(-1, 2, 3);
  EXPECT_EQ(chosen_bound(row.constraint(), 0, 2, 2.9, 10), RowSide::upper);
  EXPECT_EQ(chosen_bound(row.constraint(), 0, 2, 3.1, 10), RowSide::above);
  EXPECT_EQ(chosen_bound(row.constraint(), 0, -1, -3.1, 10), RowSide::below);
}

TEST(RowSide, BoundIsReleasedByItsMultiplier) {
  const Bounds row(-1, 2);
  const NodeConstraint c = row.constraint();
  EXPECT_EQ(revised_bound(c, 0, RowSide::upper, 2, 1), RowSide::upper);
  EXPECT_EQ(revised_bound(c, 0, RowSide::upper, 2, -1), RowSide::inactive);
  EXPECT_EQ(revised_bound(c, 0, RowSide::lower, -1, -1), RowSide::lower);
  EXPECT_EQ(revised_bound(c, 0, RowSide::lower, -1, 1), RowSide::inactive);
}

TEST(RowSide, BoundIsActivatedByAViolatingStep) {
  const Bounds row(-1, 2);
  const NodeConstraint c = row.constraint();
  EXPECT_EQ(revised_bound(c, 0, RowSide::inactive, 2 + 1e-11, 0), RowSide::inactive);
  EXPECT_EQ(revised_bound(c, 0, RowSide::inactive, 2 + 1e-9, 0), RowSide::upper);
  EXPECT_EQ(revised_bound(c, 0, RowSide::inactive, -1 - 1e-9, 0), RowSide::lower);
}

TEST(RowSide, SoftBoundReturnsWhenAStepEntersIt) {
  const Bounds row(-1, 2, 3), equality(1, 1, 3);
  EXPECT_EQ(revised_bound(row.constraint(), 0, RowSide::above, 2.5, 3), RowSide::above);
  EXPECT_EQ(revised_bound(row.constraint(), 0, RowSide::above, 1.5, 3), RowSide::upper);
  EXPECT_EQ(revised_bound(row.constraint(), 0, RowSide::below, -0.5, -3), RowSide::lower);
  EXPECT_EQ(revised_bound(equality.constraint(), 0, RowSide::above, 0.5, 3), RowSide::equality);
  EXPECT_EQ(revised_bound(row.constraint(), 0, RowSide::upper, 2, 3.5), RowSide::above);
}

TEST(RowSide, PairChoosesSmallerValueOrThePushedOne) {
  const double values[] = {0.5, 0.1}, penalties[] = {10, 10};
  RowSide sides[2];
  const double weak[] = {-4, 0}, strong[] = {-6, 0};
  choose_pair(values, weak, penalties, sides);
  EXPECT_EQ(sides[0], RowSide::inactive);
  EXPECT_EQ(sides[1], RowSide::equality);
  choose_pair(values, strong, penalties, sides);
  EXPECT_EQ(sides[0], RowSide::lower);
}

// The decision depends only on the two rows, also for later pairs.
TEST(RowSide, FirstOfEqualPairValuesIsActive) {
  const double values[] = {0.25, 0.25}, penalties[] = {10, 20}, none[] = {0, 0};
  RowSide sides[2];
  choose_pair(values, none, penalties, sides);
  EXPECT_EQ(sides[0], RowSide::equality);
  EXPECT_EQ(sides[1], RowSide::inactive);
  const double pulled[] = {0, -5};  // 0.25 − 5/20 is not negative
  choose_pair(values, pulled, penalties, sides);
  EXPECT_EQ(sides[1], RowSide::inactive);
}

TEST(RowSide, SoftRowAtItsLimitIsWithinIt) {
  const Bounds row(-1, 2, 3);
  const NodeConstraint c = row.constraint();
  EXPECT_EQ(chosen_bound(c, 0, 2, 3, 10), RowSide::upper);
  EXPECT_EQ(chosen_bound(c, 0, 2.25, 0.5, 10), RowSide::upper);
  EXPECT_EQ(revised_bound(c, 0, RowSide::upper, 2, 3), RowSide::upper);
  EXPECT_EQ(revised_bound(c, 0, RowSide::above, 2, 3), RowSide::above);
  EXPECT_EQ(revised_bound(c, 0, RowSide::below, -1, -3), RowSide::below);
  EXPECT_EQ(revised_bound(c, 0, RowSide::lower, -1, 0), RowSide::inactive);
  EXPECT_EQ(revised_bound(c, 0, RowSide::upper, 2, 0), RowSide::inactive);
}

TEST(RowSide, ConeSideIsSurfaceOrTip) {
  const Cone cone;
  const NodeConstraint c = cone.constraint();
  const double none[] = {0, 0, 0};
  const double inside[] = {0.3, 0.4, 1}, outside[] = {0.6, 0.8, 0.5}, polar[] = {0.3, 0.4, -1};
  EXPECT_EQ(chosen_cone(c, inside, none, 10), RowSide::inactive);
  EXPECT_EQ(chosen_cone(c, outside, none, 10), RowSide::surface);
  EXPECT_EQ(chosen_cone(c, polar, none, 10), RowSide::tip);
  const double on_it[] = {3, 4, 5};
  EXPECT_EQ(chosen_cone(c, on_it, none, 10), RowSide::inactive);
  EXPECT_EQ(chosen_cone(c, none, none, 10), RowSide::inactive);
  const double on_the_polar_one[] = {3, 4, -5};
  EXPECT_EQ(chosen_cone(c, on_the_polar_one, none, 10), RowSide::tip);
  // On the axis, a surface has no gradient.
  const double axis[] = {0, 0, 0.1}, push[] = {6, 0, 0};
  EXPECT_EQ(chosen_cone(c, axis, push, 10), RowSide::tip);
}

TEST(RowSide, SoftConeIsOutsideBeyondMultiplierLimit) {
  const double outside[] = {0.6, 0.8, 0.5}, none[] = {0, 0, 0};
  const double distance = 0.5 * std::sqrt(0.5);
  EXPECT_EQ(chosen_cone(Cone(10 * distance * 1.01).constraint(), outside, none, 10),
            RowSide::surface);
  EXPECT_EQ(chosen_cone(Cone(10 * distance * 0.99).constraint(), outside, none, 10),
            RowSide::outside);
}

// Multipliers alone do not put a cone outside: its own values determine the push direction.
TEST(RowSide, SoftConeInsideStaysInsideForAnyMultipliers) {
  const double inside[] = {0.3, 0.4, 0.6}, push[] = {60, 80, 0};
  EXPECT_EQ(chosen_cone(Cone(0.1).constraint(), inside, push, 10), RowSide::surface);
  const double on_it[] = {3, 4, 5};
  EXPECT_EQ(chosen_cone(Cone(0.1).constraint(), on_it, push, 10), RowSide::surface);
}

TEST(RowSide, ConeRevisionFollowsMultipliersAndViolation) {
  const Cone cone;
  const NodeConstraint c = cone.constraint();
  const double start[] = {0.3, 0.4, 0.5}, tip[] = {0, 0, 0};
  const Eigen::Vector3d inside(0.3, 0.4, 1), outside(0.6, 0.8, 0.5);
  const Eigen::Vector3d pushes(0.6, 0.8, -1), pulls(0.6, 0.8, 1), in_polar_cone(0.3, 0.4, -1);
  EXPECT_EQ(revised_cone(c, RowSide::inactive, start, inside, pushes), RowSide::inactive);
  EXPECT_EQ(revised_cone(c, RowSide::inactive, start, outside, pushes), RowSide::surface);
  EXPECT_EQ(revised_cone(c, RowSide::inactive, tip, outside, pushes), RowSide::tip);
  EXPECT_EQ(revised_cone(c, RowSide::surface, start, inside, pushes), RowSide::surface);
  EXPECT_EQ(revised_cone(c, RowSide::surface, start, inside, pulls), RowSide::inactive);
  EXPECT_EQ(revised_cone(c, RowSide::tip, start, inside, in_polar_cone), RowSide::tip);
  EXPECT_EQ(revised_cone(c, RowSide::tip, start, inside, pulls), RowSide::surface);
  EXPECT_EQ(revised_cone(c, RowSide::tip, tip, inside, pulls), RowSide::tip);
}

TEST(RowSide, SoftConeReturnsWhenAStepEntersIt) {
  const Cone cone(2);
  const NodeConstraint c = cone.constraint();
  const double beyond[] = {0.6, 0.8, 0.5};
  const Eigen::Vector3d inside(0.3, 0.4, 1), outside(0.6, 0.8, 0.5);
  const Eigen::Vector3d within_limit(0.6, 0.8, -1), beyond_limit(1.2, 1.6, -2);
  EXPECT_EQ(revised_cone(c, RowSide::outside, beyond, outside, beyond_limit), RowSide::outside);
  EXPECT_EQ(revised_cone(c, RowSide::outside, beyond, inside, beyond_limit), RowSide::surface);
  EXPECT_EQ(revised_cone(c, RowSide::surface, beyond, inside, beyond_limit), RowSide::outside);
  EXPECT_EQ(revised_cone(c, RowSide::surface, beyond, inside, within_limit), RowSide::surface);
}

TEST(RowSide, ControlIsActiveAtBoundsTheGradientPushes) {
  EXPECT_EQ(chosen_control(0, -1, 1, 5), RowSide::inactive);
  EXPECT_EQ(chosen_control(-1, -1, 1, 5), RowSide::lower);
  EXPECT_EQ(chosen_control(-1, -1, 1, -5), RowSide::inactive);
  EXPECT_EQ(chosen_control(1, -1, 1, -5), RowSide::upper);
  EXPECT_EQ(chosen_control(1.1, -1, 1, 5), RowSide::upper);
  EXPECT_EQ(chosen_control(-1.1, -1, 1, -5), RowSide::lower);
  EXPECT_EQ(chosen_control(-1, -1, 1, 0), RowSide::inactive);
  EXPECT_EQ(chosen_control(1, -1, 1, 0), RowSide::inactive);
  EXPECT_EQ(chosen_control(-1 + 1e-10, -1, 1, 5), RowSide::lower);
  EXPECT_EQ(chosen_control(-1 + 1e-8, -1, 1, 5), RowSide::inactive);
  EXPECT_EQ(chosen_control(1 - 1e-10, -1, 1, -5), RowSide::upper);
  EXPECT_EQ(chosen_control(1 - 1e-8, -1, 1, -5), RowSide::inactive);
  EXPECT_EQ(chosen_control(0.5, 0.5, 0.5, 5), RowSide::lower);
  EXPECT_EQ(chosen_control(0.5, 0.5, 0.5, -5), RowSide::upper);
}

}  // namespace
}  // namespace conddp
