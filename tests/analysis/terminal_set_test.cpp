// Largest ellipsoids within bounds and constraints of a regulated mass. On yᵀP y ≤ level, a linear
// function a·x reaches √(level aᵀP⁻¹a).
#include "analysis/terminal/terminal_set.hpp"

#include <cmath>
#include <limits>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "analysis/terminal/terminal_ingredients.hpp"
#include "support/regulated_mass.hpp"

namespace conddp {
namespace {

using testing::mass_stage;
using testing::pushed_mass;
using testing::regulated;
using testing::StageConstraint;

constexpr double kNoBound = std::numeric_limits<double>::infinity();

/// Ingredients of the mass with a constraint, and its largest set.
struct ConstrainedMass {
  explicit ConstrainedMass(std::vector<StageConstraint> constraints, double force = kNoBound)
      : own(*regulated(mass_stage(pushed_mass(1), {-force}, {force}, std::move(constraints)))
                 .ingredients),
        set(largest_terminal_set(own)),
        inverse(own.P.inverse()) {}

  double level(const Eigen::RowVectorXd& row, double distance) const {
    return distance * distance / (row * inverse * row.transpose())(0, 0);
  }

  TerminalIngredients own;
  TerminalSet set;
  Eigen::MatrixXd inverse;  ///< inverse of P
};

std::shared_ptr<const Residual> whole_state() { return state_residual(StateManifold::flat(2)); }

/// Linear functions of position and speed.
std::shared_ptr<const Residual> functions_of_state(
    const std::vector<std::array<double, 3>>& factors_and_constants) {
  std::vector<LinearCombination> rows;
  for (const auto& [place, speed, constant] : factors_and_constants)
    rows.push_back({.terms = {{place, false, 0, 0}, {speed, false, 1, 1}}, .constant = constant});
  return combination_residual(2, std::move(rows));
}

TEST(TerminalSet, TouchesTheNearerBoundOfEachRow) {
  const ConstrainedMass mass(
      {{make_constraint("box", whole_state(), ConstraintKind::bounds),
        {0.05, -0.1, -0.3, -0.2, 0.5, 0.6, 1}},
       {make_constraint("speed", coordinate_residual(StateManifold::flat(2), {1}),
                        ConstraintKind::bounds),
        {0, -0.8, 0.7, 1}}},
      1);
  // At the origin, the rows of the box are −0.05 and 0.1.
  const struct {
    const char* name;
    double distance, level;
  } expected[] = {
      {"u/0", 1, mass.level(mass.own.K, 1)},
      {"box row 1", 0.25, mass.level(Eigen::RowVector2d(1, 0), 0.25)},
      {"box row 2", 0.3, mass.level(Eigen::RowVector2d(0, 1), 0.3)},
      {"speed", 0.7, mass.level(Eigen::RowVector2d(0, 1), 0.7)},
  };
  ASSERT_EQ(mass.set.bounds.size(), 4u);
  for (const auto& bound : expected) {
    const auto found = std::find_if(mass.set.bounds.begin(), mass.set.bounds.end(),
                                    [&](const TerminalBound& b) { return b.name == bound.name; });
    ASSERT_NE(found, mass.set.bounds.end()) << bound.name;
    EXPECT_NEAR(found->distance, bound.distance, 1e-15) << bound.name;
    EXPECT_NEAR(found->level, bound.level, 1e-12 * bound.level) << bound.name;
  }
  for (std::size_t i = 1; i < 4; ++i)
    EXPECT_LE(mass.set.bounds[i - 1].level, mass.set.bounds[i].level);
  EXPECT_EQ(mass.set.level, mass.set.bounds[0].level);
}

TEST(TerminalSet, EvaluatesControlConstraintsUnderTheRegulator) {
  const ConstrainedMass mass(
      {{make_constraint("push", control_residual(2, 1), ConstraintKind::bounds), {0, -0.5, 2, 1}}});
  ASSERT_EQ(mass.set.bounds.size(), 1u);
  EXPECT_NEAR(mass.set.bounds[0].distance, 0.5, 1e-15);
  EXPECT_NEAR(mass.set.level, mass.level(mass.own.K, 0.5), 1e-13);
}

TEST(TerminalSet, IgnoresSoftDisabledAndUnboundedConstraints) {
  const auto speed = coordinate_residual(StateManifold::flat(2), {1});
  const auto soft = make_constraint("soft", speed, ConstraintKind::bounds, 1, Softness::l1);
  const auto hard = make_constraint("hard", speed, ConstraintKind::bounds);
  const ConstrainedMass mass({{soft, {0, -0.1, 0.1, 1, 5}},
                              {hard, {0, -0.1, 0.1, 0}},
                              {hard, {0, -kNoBound, kNoBound, 1}}});
  EXPECT_TRUE(mass.set.bounds.empty());
  EXPECT_EQ(mass.set.level, kNoBound);
}

TEST(TerminalSet, IsEmptyIfTheEquilibriumViolatesAConstraint) {
  const auto speed = coordinate_residual(StateManifold::flat(2), {1});
  const ConstrainedMass mass(
      {{make_constraint("fast", speed, ConstraintKind::bounds), {0, 0.1, 0.4, 1}}});
  EXPECT_EQ(mass.set.level, 0);
  ASSERT_EQ(mass.set.bounds.size(), 1u);
  EXPECT_NEAR(mass.set.bounds[0].distance, -0.1, 1e-15);
}

// ‖x − (0.3, −0.4)‖ is 0.5 at the origin. Any direction may increase it; only its gradient
// decreases it.
TEST(TerminalSet, TouchesNormsFromAboveAndFromBelow) {
  const auto norm = make_constraint("norm", whole_state(), ConstraintKind::norm);
  const ConstrainedMass above({{norm, {0.3, -0.4, 0, 0.7, 1}}});
  ASSERT_EQ(above.set.bounds.size(), 1u);
  EXPECT_NEAR(above.set.bounds[0].distance, 0.2, 1e-15);
  const double widest =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(above.inverse).eigenvalues()[1];
  EXPECT_NEAR(above.set.level, 0.04 / widest, 1e-13);
  const ConstrainedMass below({{norm, {0.3, -0.4, 0.2, kNoBound, 1}}});
  ASSERT_EQ(below.set.bounds.size(), 1u);
  EXPECT_NEAR(below.set.bounds[0].distance, 0.3, 1e-15);
  EXPECT_NEAR(below.set.level, below.level(Eigen::RowVector2d(-0.6, 0.8), 0.3), 1e-12);
  const ConstrainedMass both({{norm, {0.3, -0.4, 0.2, 0.7, 1}}});
  EXPECT_EQ(both.set.bounds.size(), 2u);
  EXPECT_NEAR(both.set.level, std::min(above.set.level, below.set.level), 1e-15);
  const ConstrainedMass violated({{norm, {0.3, -0.4, 0.6, kNoBound, 1}}});
  EXPECT_EQ(violated.set.level, 0);
  EXPECT_NEAR(violated.set.bounds[0].distance, -0.1, 1e-15);
}

// ‖(place + 0.1, 2 speed − 0.2)‖ ≤ 1.5 (2 + 0.5 place).
TEST(TerminalSet, TouchesConesInTheWorstDirection) {
  const ConstrainedMass mass(
      {{make_constraint("cone", functions_of_state({{1, 0, 0.1}, {0, 2, -0.2}, {0.5, 0, 2}}),
                        ConstraintKind::second_order_cone, 1.5),
        {1}}});
  ASSERT_EQ(mass.set.bounds.size(), 1u);
  EXPECT_EQ(mass.set.bounds[0].name, "cone");
  const double distance = 3 - std::hypot(0.1, 0.2);
  EXPECT_NEAR(mass.set.bounds[0].distance, distance, 1e-14);
  const Eigen::Matrix2d sides = Eigen::Vector2d(1, 2).asDiagonal();
  const double side =
      std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(sides * mass.inverse * sides)
                    .eigenvalues()[1]);
  const double reach = side + 0.75 * std::sqrt(mass.inverse(0, 0));
  EXPECT_NEAR(mass.set.level, std::pow(distance / reach, 2), 1e-11);
}

/// Two decaying states: only the first has a cost and a control.
Phase decaying_stage(std::vector<StageConstraint> constraints) {
  const auto system = linear_system(Eigen::Vector2d(0.5, 0.9).asDiagonal().toDenseMatrix(),
                                    Eigen::Matrix2d{{0.5, 0}, {0, 0}}, Eigen::Vector2d::Zero());
  return testing::stage_of(system, {.reference = {0, 0}, .state = {1, 0}}, {-3, -2}, {2, 4},
                           std::move(constraints));
}

// The second state costs nothing and is unbounded in the set; the second control has no gains.
TEST(TerminalSet, IsEmptyIfCostlessDirectionsAreBounded) {
  const auto bounded = [](int state) {
    const auto one = coordinate_residual(StateManifold::flat(2), {state});
    return largest_terminal_set(
        *regulated(decaying_stage(
                       {{make_constraint("bounded", one, ConstraintKind::bounds), {0, -1, 2, 1}}}))
             .ingredients);
  };
  const TerminalSet first = bounded(0), second = bounded(1);
  ASSERT_EQ(first.bounds.size(), 2u);
  ASSERT_EQ(second.bounds.size(), 2u);
  const TerminalIngredients own = *regulated(decaying_stage({})).ingredients;
  EXPECT_EQ(own.P(1, 1), 0);
  for (const TerminalBound& bound : first.bounds) {
    const double distance = bound.name == "u/0" ? 2 : 1;
    EXPECT_EQ(bound.distance, distance) << bound.name;
    const double reach = bound.name == "u/0" ? std::abs(own.K(0, 0)) : 1;
    EXPECT_NEAR(bound.level, std::pow(distance / reach, 2) * own.P(0, 0), 1e-12) << bound.name;
  }
  EXPECT_EQ(second.level, 0);
  EXPECT_EQ(second.bounds[0].name, "bounded");
  EXPECT_EQ(second.bounds[0].distance, 1);
}

TEST(TerminalEllipsoid, HasMatrixAxesAndNullDirections) {
  // Rank two of three: (1, 2, 2)/3 costs nothing.
  const Eigen::Vector3d none = Eigen::Vector3d(1, 2, 2) / 3;
  Eigen::Matrix<double, 3, 2> across;
  across << 2, -2, -2, -1, 1, 2;
  across /= 3;
  const Eigen::Matrix3d P = across * Eigen::Vector2d(4, 0.25).asDiagonal() * across.transpose();
  const TerminalEllipsoid own = terminal_ellipsoid(P);
  ASSERT_EQ(own.axes.cols(), 2);
  ASSERT_EQ(own.free.cols(), 1);
  EXPECT_LT((own.axes.transpose() * P * own.axes - Eigen::Matrix2d::Identity()).norm(), 1e-14);
  EXPECT_NEAR(std::abs(own.free.col(0).dot(none)), 1, 1e-14);
  EXPECT_EQ(terminal_ellipsoid(Eigen::Matrix2d::Zero()).axes.cols(), 0);
  EXPECT_EQ(terminal_ellipsoid(Eigen::Matrix2d::Zero()).free.cols(), 2);
  EXPECT_EQ(terminal_ellipsoid(Eigen::Matrix2d{{2, 1}, {1, 2}}).free.cols(), 0);
}

TEST(TerminalEllipsoid, RoundingOfASingularMatrixHasNoLength) {
  // Rows of very different units; one of them is rounding.
  const Eigen::Vector3d row(1e3, -2e-3, 0);
  Eigen::Matrix3d P = row * row.transpose();
  P(2, 2) = 1e-26;
  P(1, 1) *= 1 + 1e-15;
  const Eigen::Matrix3d clean = without_rounding(P);
  EXPECT_LT((clean - row * row.transpose()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(clean(1, 1), 4e-6, 1e-18);
  EXPECT_TRUE(clean.row(2).isZero(0) && clean.col(2).isZero(0));
  EXPECT_EQ(clean, clean.transpose());
  const Eigen::Matrix2d regular{{2, 1e-3}, {1e-3, 1e-6}};
  EXPECT_EQ(without_rounding(regular), regular);
}

}  // namespace
}  // namespace conddp
