// Active rows and their equations, compared with hand-computed numbers and with the enumeration of
// all sets.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/constraints/horizon_qp.hpp"
#include "solvers/riccati/adjoint.hpp"
#include "support/dense_horizon.hpp"
#include "support/linear_quadratic.hpp"
#include "support/small_qp.hpp"

namespace conddp::testing {
namespace {

/// Constraint rows of every kind at three nodes.
enum Row { kBand = 0, kCone = 4, kSoftCone = 7, kPair = 10, kEqual = 12, kSoft = 13, kRows = 15 };
/// Limits of the multipliers of soft rows.
constexpr double kSoftLimit = 2, kSoftConeLimit = 3;
constexpr double kPenalty = 10;

/// Dimensions: three controls at the first node and two at the second, within ± 1; two states. The
/// first node has four rows in ± 1, a hard cone, and a soft cone; the second has a pair; the last
/// has a row equal to 0.5 and two soft rows in ± 1.
ShootingProblem problem_of_all_kinds() {
  const LinearQuadratic lq(1, 2, {3, 2}, 1, -1, 1);
  const ShootingProblem& free = *lq.problem;
  const auto ones = [](int rows, int columns) -> Eigen::MatrixXd {
    return Eigen::MatrixXd::Ones(rows, columns);
  };
  Added band = affine_rows(ones(4, 5), free, 0, 0, -1, 1);
  Added cone = affine_rows(ones(3, 5), free, 0, 0, 0, 0);
  Added pair = {.name = "pair",
                .residual = control_residual(free.ndx(), 2),
                .kind = ConstraintKind::complementarity,
                .reference = {0, 0},
                .first = 1,
                .last = 1};
  Added equal = affine_rows(ones(1, 2), free, 2, 2, 0.5, 0.5);
  Added soft = affine_rows(ones(2, 2), free, 2, 2, -1, 1);
  Added soft_cone = affine_rows(ones(3, 5), free, 0, 0, 0, 0);
  for (Added* c : {&cone, &soft_cone}) {
    c->kind = ConstraintKind::second_order_cone;
    c->lower.clear();
    c->upper.clear();
  }
  for (Added* c : {&soft, &soft_cone}) c->softness = Softness::l1;
  soft.weight = kSoftLimit;
  soft_cone.weight = kSoftConeLimit / free.knot(0).cost_scale;
  return with_constraints(free, {band, cone, soft_cone, pair, equal, soft});
}

/// The same dimensions with random derivatives, values inside their sets, and zeros elsewhere.
struct AllKinds {
  AllKinds()
      : problem(problem_of_all_kinds()),
        bounds(problem),
        linearization(problem),
        rows(problem, bounds),
        multipliers(Eigen::VectorXd::Zero(kRows)) {
    EXPECT_EQ(problem.constraint_rows(), kRows);
    RandomNumbers random(1);
    randomize(problem, random, linearization);
    linearization.constraint << 0, 0, 0, 0,  // band
        0.3, 0.4, 2, 0.3, 0.4, 2,            // cones
        1, 0,                                // pair
        0.5, 0, 0;                           // equal, soft
  }
  /// Chooses the rows of a model without costs.
  void choose() {
    for (KnotLinearization& knot : linearization.knots) {
      knot.gradient.setZero();
      knot.hessian.change().setZero();
    }
    rows.choose(linearization, Eigen::VectorXd::Constant(kRows, kPenalty), multipliers);
  }
  Eigen::RowVectorXd C(int row) const {
    const int node = row < kPair ? 0 : row < kEqual ? 1 : 2;
    return linearization.knots[node].C.row(row - problem.constraint_offset(node));
  }

  ShootingProblem problem;
  ControlBounds bounds;
  Linearization linearization;
  HorizonRows rows;
  Eigen::VectorXd multipliers;
};

/// A row value + a z = 0 with its multiplier. A surface takes half of ρ.
struct ExpectedRow {
  Eigen::RowVectorXd a;
  double value, multiplier, share = 1;
};

/// Compares the contributions of a node's rows to gradient and Hessian. `curvature` is their own
/// curvature; `pushed` rows at a limit contribute only multipliers.
void expect_rows(AllKinds& at, int node, const std::vector<ExpectedRow>& expected,
                 const Eigen::MatrixXd& curvature = {},
                 const std::vector<ExpectedRow>& pushed = {}) {
  SCOPED_TRACE(fmt::format("node {}", node));
  KnotLinearization& knot = at.linearization.knots[node];
  const int nz = static_cast<int>(knot.gradient.size());
  Eigen::VectorXd slope = Eigen::VectorXd::Zero(nz), change = slope;
  Eigen::MatrixXd squares = Eigen::MatrixXd::Zero(nz, nz);
  if (curvature.size() > 0) squares = curvature;
  std::vector<Eigen::VectorXd> step;
  for (const KnotLinearization& each : at.linearization.knots)
    step.push_back(Eigen::VectorXd::LinSpaced(each.gradient.size(), -0.2, 0.3));
  for (const ExpectedRow& row : expected) {
    const double penalty = row.share * kPenalty;
    slope += (row.multiplier + penalty * row.value) * row.a.transpose();
    change += penalty * (row.value + row.a * step[node]) * row.a.transpose();
    squares += penalty * row.a.transpose() * row.a;
  }
  for (const ExpectedRow& row : pushed) slope += row.multiplier * row.a.transpose();
  at.choose();
  at.rows.impose(at.multipliers, kPenalty, at.linearization);
  EXPECT_LT((knot.gradient - slope).lpNorm<Eigen::Infinity>(), 1e-12);
  EXPECT_LT((knot.hessian() - squares).lpNorm<Eigen::Infinity>(), 1e-12);
  at.rows.correct(step, at.linearization);
  EXPECT_LT((knot.gradient - slope - change).lpNorm<Eigen::Infinity>(), 1e-12) << "after a step";
}

// With ρ = 10 and s = g + ν/ρ: 1.05 and 1.3 are above, 0.1 inside, −1.01 below.
TEST(ActiveRows, BoundsAreActiveWhereShiftedValueIsOutside) {
  AllKinds at;
  at.linearization.constraint.head(4) << 1.05, 0.5, -0.2, -1.02;
  at.multipliers.head(4) << 0, 8, 3, 0.1;
  at.multipliers[kEqual] = -4;
  at.linearization.constraint[kEqual] = 0.7;
  at.choose();
  EXPECT_EQ(at.multipliers.head(4), Eigen::Vector4d(0, 8, 0, 0.1));
  EXPECT_EQ(at.multipliers[kEqual], -4);
  EXPECT_EQ(at.rows.active_rows(), 5) << "with the equality and the smaller one of the pair";
  expect_rows(at, 0, {{at.C(0), 0.05, 0}, {at.C(1), -0.5, 8}, {at.C(3), -0.02, 0.1}});
  expect_rows(at, 1, {{at.C(kPair + 1), 0, 0}});
  expect_rows(at, 2, {{at.C(kEqual), 0.2, -4}});
  EXPECT_DOUBLE_EQ(at.rows.impose(at.multipliers, kPenalty, at.linearization), 0.5);
}

TEST(ActiveRows, SmallerPairValueAndPushedOtherAreActive) {
  for (const bool swapped : {false, true})
    for (const bool both : {false, true}) {
      AllKinds at;
      const int larger = kPair + swapped, smaller = kPair + !swapped;
      at.linearization.constraint[larger] = 0.3;
      at.linearization.constraint[smaller] = -0.1;
      at.multipliers[larger] = both ? -4 : -2;  // 0.3 − 0.4, 0.3 − 0.2
      at.multipliers[smaller] = 5;
      at.choose();
      EXPECT_EQ(at.multipliers[smaller], 5);
      EXPECT_EQ(at.multipliers[larger], both ? -4 : 0);
      std::vector<ExpectedRow> expected{{at.C(smaller), -0.1, 5}};
      if (both) expected.push_back({at.C(larger), 0.3, -4});
      expect_rows(at, 1, expected);
    }
}

TEST(ActiveRows, SeveralPairsHaveSeparateChoices) {
  const LinearQuadratic lq(1, 2, {4}, 1, -1, 1);
  const ShootingProblem problem =
      with_constraints(*lq.problem, {{.name = "pairs",
                                      .residual = control_residual(2, 4),
                                      .kind = ConstraintKind::complementarity,
                                      .reference = {0, 0, 0, 0},
                                      .first = 0,
                                      .last = 0}});
  const ControlBounds bounds(problem);
  Linearization linearization(problem);
  linearization.constraint << 3, 0.25, -0.5, 2;
  linearization.knots[0].C.rightCols(4).setIdentity();
  HorizonRows rows(problem, bounds);
  Eigen::VectorXd multipliers = Eigen::Vector4d(5, 6, 7, 8), penalty = Eigen::Vector4d(1, 1, 2, 2);
  rows.choose(linearization, penalty, multipliers);
  EXPECT_EQ(multipliers, Eigen::Vector4d(0, 6, 7, 0));
  // −8 moves the larger value of the second pair 8/2 below zero, but not with twice the penalty.
  for (const double weight : {2.0, 5.0}) {
    multipliers << 5, 6, 7, -8;
    penalty << 1, 1, 1, weight;
    rows.choose(linearization, penalty, multipliers);
    EXPECT_EQ(multipliers, Eigen::Vector4d(0, 6, 7, weight == 2 ? -8 : 0)) << weight;
  }
}

// The values (3, 4, 2) lie outside the cone by 5 − 2, and the surface curvature is 1/5.
TEST(ActiveRows, ConeSurfaceIsActiveWithItsCurvature) {
  AllKinds at;
  at.linearization.constraint.segment(kCone, 3) << 3, 4, 2;
  at.multipliers.segment(kCone, 3) << 0.1, 0.2, -0.7;
  at.choose();
  EXPECT_LT((at.multipliers.segment(kCone, 3) - Eigen::Vector3d(0.42, 0.56, -0.7)).norm(), 1e-15)
      << "along the surface's normal";
  const Eigen::RowVectorXd a = at.C(kCone), b = at.C(kCone + 1), c = at.C(kCone + 2);
  const Eigen::RowVectorXd along = 0.6 * a + 0.8 * b;
  const Eigen::MatrixXd bend =
      0.7 / 5 * (a.transpose() * a + b.transpose() * b - along.transpose() * along);
  expect_rows(at, 0, {{along - c, 3, 0.7, 0.5}}, bend);
}

TEST(ActiveRows, ConeTipIsActiveWhereNearest) {
  AllKinds at;
  at.linearization.constraint.segment(kCone, 3) << 0.6, 0.8, -1.1;
  at.multipliers.segment(kCone, 3) << 1, 2, -3;
  at.choose();
  EXPECT_EQ(at.multipliers.segment(kCone, 3), Eigen::Vector3d(1, 2, -3));
  expect_rows(at, 0,
              {{at.C(kCone), 0.6, 1}, {at.C(kCone + 1), 0.8, 2}, {at.C(kCone + 2), -1.1, -3}});
}

// Beyond limit/ρ = 0.2, a soft row contributes its limit and is not an equation.
TEST(ActiveRows, SoftRowBeyondLimitKeepsOnlyItsMultiplier) {
  AllKinds at;
  at.linearization.constraint.segment(kSoft, 2) << 1.1, -1.5;
  at.choose();
  EXPECT_EQ(at.multipliers.segment(kSoft, 2), Eigen::Vector2d(0, -kSoftLimit));
  EXPECT_EQ(at.rows.active_rows(), 3) << "with the equality and the pair";
  expect_rows(at, 2, {{at.C(kEqual), 0, 0}, {at.C(kSoft), 0.1, 0}}, {},
              {{at.C(kSoft + 1), 0, -kSoftLimit}});
}

// The distance of (3, 4, 2) is (‖(3, 4)‖ − 2)/√2; it decreases along (0.6, 0.8, −1)/√2.
TEST(ActiveRows, SoftConeBeyondLimitHasDistanceCurvature) {
  AllKinds at;
  at.linearization.constraint.segment(kSoftCone, 3) << 3, 4, 2;
  at.choose();
  const double limit = kSoftConeLimit / std::sqrt(2);
  EXPECT_LT((at.multipliers.segment(kSoftCone, 3) - limit * Eigen::Vector3d(0.6, 0.8, -1)).norm(),
            1e-14);
  const Eigen::RowVectorXd a = at.C(kSoftCone), b = at.C(kSoftCone + 1);
  const Eigen::RowVectorXd along = 0.6 * a + 0.8 * b;
  const Eigen::MatrixXd bend =
      limit / 5 * (a.transpose() * a + b.transpose() * b - along.transpose() * along);
  expect_rows(at, 0, {}, bend,
              {{a, 0, 0.6 * limit}, {b, 0, 0.8 * limit}, {at.C(kSoftCone + 2), 0, -limit}});
}

// The distance 0.3/√2 is less than limit/ρ = 0.3; ‖(0.6, 0.8, 0.7)‖ is larger.
TEST(ActiveRows, SoftConeWithinLimitHasItsSurfaceActive) {
  AllKinds at;
  at.linearization.constraint.segment(kSoftCone, 3) << 0.6, 0.8, 0.7;
  at.choose();
  expect_rows(
      at, 0,
      {{0.6 * at.C(kSoftCone) + 0.8 * at.C(kSoftCone + 1) - at.C(kSoftCone + 2), 0.3, 0, 0.5}});
}

/// Revises the rows of `AllKinds` by a step that changes values by `change`, with ρ = 10. Records
/// their count and which of them have curvature.
struct Revised {
  Revised(int first, const Eigen::VectorXd& values, const Eigen::VectorXd& multipliers,
          const Eigen::VectorXd& change) {
    const int n = static_cast<int>(values.size());
    at.linearization.constraint.segment(first, n) = values;
    at.multipliers.segment(first, n) = multipliers;
    // These rows are entries of z times a scale that keeps control steps within bounds.
    constexpr double kScale = 64;
    const int node = first < kPair ? 0 : first < kEqual ? 1 : 2;
    const int offset = at.problem.constraint_offset(node);
    std::vector<Eigen::VectorXd> step;
    for (KnotLinearization& knot : at.linearization.knots) {
      knot.C.setZero();
      step.push_back(Eigen::VectorXd::Zero(knot.gradient.size()));
    }
    KnotLinearization& knot = at.linearization.knots[node];
    knot.C.block(first - offset, 0, n, n).diagonal().setConstant(kScale);
    step[node].head(n) = change / kScale;
    at.choose();
    at.rows.impose(at.multipliers, kPenalty, at.linearization);
    changed = at.rows.revise_active(step, at.linearization) > 0;
    curvature = knot.hessian().topLeftCorner(n, n) / (kPenalty * kScale * kScale);
    at.rows.write_multipliers(at.multipliers);
    written = at.multipliers.segment(first, n);
  }
  AllKinds at;
  bool changed;
  Eigen::MatrixXd curvature;
  Eigen::VectorXd written;
};

using Numbers = Eigen::VectorXd;
Numbers numbers(std::initializer_list<double> list) {
  return Eigen::Map<const Numbers>(list.begin(), static_cast<Eigen::Index>(list.size()));
}

TEST(ActiveRows, StepRevisesWrongMultipliersAndViolatedRows) {
  // Multipliers after the step: 10 (0.05 − 0.04) > 0; 8 + 10 (−0.5 − 0.4) < 0 at an upper bound;
  // inactive, but 1.1 is beyond; 0.1 − 10·0.02 < 0 at a lower bound.
  const Revised all(kBand, numbers({1.05, 0.5, -0.2, -1.02}), numbers({0, 8, 0, 0.1}),
                    numbers({-0.04, -0.4, 1.3, 0}));
  EXPECT_TRUE(all.changed);
  EXPECT_EQ(all.curvature.diagonal(), Eigen::Vector4d(1, 0, 1, 1));
  // The opposite sides: 0.1 at a lower bound has the wrong sign, −1.1 is beyond.
  const Revised low(kBand, numbers({-1.02, -0.2, 0, 0}), numbers({-1, 0, 0, 0}),
                    numbers({0.13, -0.9, 0.99, -0.99}));
  EXPECT_TRUE(low.changed);
  EXPECT_EQ(low.curvature.diagonal(), Eigen::Vector4d(0, 1, 0, 0));
  const Revised none(kBand, numbers({1.05, 0.5, -0.2, -1.02}), numbers({0, 8, 0, 0.1}),
                     numbers({-0.04, 0.1, 1.1, 0}));
  EXPECT_FALSE(none.changed);
  EXPECT_EQ(none.curvature.diagonal(), Eigen::Vector4d(1, 1, 0, 1));
}

TEST(ActiveRows, StepRevisesSoftRowsByTheirLimit) {
  // 1.1 is active, and 10 (0.1 + 0.15) exceeds its limit 2; −1.5 is beyond and returns.
  const Revised rows(kSoft, numbers({1.1, -1.5}), numbers({0, 0}), numbers({0.15, 0.6}));
  EXPECT_TRUE(rows.changed);
  EXPECT_EQ(rows.curvature.diagonal(), Eigen::Vector2d(0, 1));
  EXPECT_EQ(rows.written, Eigen::Vector2d(kSoftLimit, -kSoftLimit));
  const Revised others(kSoft, numbers({-1.1, 1.5}), numbers({0, 0}), numbers({-0.15, -0.6}));
  EXPECT_TRUE(others.changed);
  EXPECT_EQ(others.curvature.diagonal(), Eigen::Vector2d(0, 1));
  EXPECT_EQ(others.written, Eigen::Vector2d(-kSoftLimit, kSoftLimit));
  const Revised stay(kSoft, numbers({1.1, -1.5}), numbers({0, 0}), numbers({0.05, 0.4}));
  EXPECT_FALSE(stay.changed);
  EXPECT_EQ(stay.curvature.diagonal(), Eigen::Vector2d(1, 0));
}

TEST(ActiveRows, StepRevisesSoftConesByTheirLimit) {
  // The surface multiplier ½ · 10 (0.4 + 0.05) along (0.6, 0.8, −1) has norm 3.2, above the limit.
  const Eigen::Vector3d direction = Eigen::Vector3d(0.6, 0.8, -1) / std::sqrt(2);
  const Revised leaves(kSoftCone, numbers({0.6, 0.8, 0.6}), numbers({0, 0, 0}),
                       numbers({0, 0, -0.05}));
  EXPECT_TRUE(leaves.changed);
  EXPECT_LT((leaves.written - kSoftConeLimit * direction).norm(), 1e-14);
  const Revised stays(kSoftCone, numbers({0.6, 0.8, 0.7}), numbers({0, 0, 0}),
                      numbers({0, 0, 0.1}));
  EXPECT_FALSE(stays.changed);
  // From beyond the limit, it returns to the surface if the step ends inside.
  const Revised back(kSoftCone, numbers({3, 4, 2}), numbers({0, 0, 0}), numbers({0, 0, 3.1}));
  EXPECT_TRUE(back.changed);
  EXPECT_GT(back.curvature.norm(), 1);
  const Revised beyond(kSoftCone, numbers({3, 4, 2}), numbers({0, 0, 0}), numbers({0, 0, 2.9}));
  EXPECT_FALSE(beyond.changed);
  EXPECT_LT((beyond.written - kSoftConeLimit * direction).norm(), 1e-14);
}

TEST(ActiveRows, StepRevisesTheLargerOfAPair) {
  // 0.3 moves to −0.1; or its multiplier −4 becomes −4 + 10 (0.3 + 0.2) > 0.
  const Revised enters(kPair, numbers({0.3, 0}), numbers({0, 0}), numbers({-0.4, 0}));
  EXPECT_TRUE(enters.changed);
  EXPECT_EQ(enters.curvature.diagonal(), Eigen::Vector2d(1, 1));
  const Revised leaves(kPair, numbers({0.3, 0}), numbers({-4, 0}), numbers({0.2, 0}));
  EXPECT_TRUE(leaves.changed);
  EXPECT_EQ(leaves.curvature.diagonal(), Eigen::Vector2d(0, 1));
  const Revised stays(kPair, numbers({0.3, 0}), numbers({-4, 0}), numbers({-0.3, 0}));
  EXPECT_FALSE(stays.changed);
}

TEST(ActiveRows, StepRevisesCones) {
  // From inside, (0.3, 0.4, 2) moves to (0.3, 0.4, 0.4): the surface along (0.6, 0.8, −1).
  const Revised enters(kCone, numbers({0.3, 0.4, 2}), numbers({0, 0, 0}), numbers({0, 0, -1.6}));
  EXPECT_TRUE(enters.changed);
  const Eigen::Vector3d normal(0.6, 0.8, -1);
  EXPECT_LT((enters.curvature - 0.5 * normal * normal.transpose()).norm(), 1e-14);
  // The surface multiplier 0.7 becomes 0.7 + ½ · 10 (3 − 3.2).
  const Revised leaves(kCone, numbers({3, 4, 2}), numbers({0.42, 0.56, -0.7}),
                       numbers({0, 0, 3.2}));
  EXPECT_TRUE(leaves.changed);
  EXPECT_LT(leaves.curvature.norm(), 1e-14);
  const Revised stays(kCone, numbers({3, 4, 2}), numbers({0.42, 0.56, -0.7}),
                      numbers({0, 0, 3.05}));
  EXPECT_FALSE(stays.changed);
  // The tip multipliers become (6, 8, −11) + 10 (0, 0, 0.2), which lies outside the polar cone.
  const Revised tip(kCone, numbers({0.6, 0.8, -1.1}), numbers({0, 0, 0}), numbers({0, 0, 0.2}));
  EXPECT_TRUE(tip.changed);
  EXPECT_LT((tip.curvature - 0.5 * normal * normal.transpose()).norm(), 1e-14);
  const Revised held(kCone, numbers({0.6, 0.8, -1.1}), numbers({0, 0, 0}), numbers({0, 0, 0.05}));
  EXPECT_FALSE(held.changed);
  EXPECT_EQ(held.curvature, Eigen::MatrixXd::Identity(3, 3));
}

// Newton steps on active rows, revised until they settle, reach the solution of the quadratic
// program.
TEST(ActiveRows, RevisedSetMatchesTheQuadraticProgram) {
  int bounds_held = 0, rows_held = 0, sweeps = 0, cycles = 0;
  for (unsigned seed = 1; seed <= 24; ++seed) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const LinearQuadratic lq(1, 2 + seed % 2, {2, 1}, 1, -0.4, 0.4);
    const int nx = lq.nx;
    const ShootingProblem problem = with_constraints(
        *lq.problem, {affine_rows(Eigen::MatrixXd::Ones(1, nx + 2), *lq.problem, 0, 0, -0.3, 0.3),
                      affine_rows(Eigen::MatrixXd::Ones(1, nx + 1), *lq.problem, 1, 1, -0.3, 0.3),
                      affine_rows(Eigen::MatrixXd::Ones(1, nx), *lq.problem, 2, 2, -0.3, 0.3),
                      affine_rows(Eigen::MatrixXd::Ones(1, nx), *lq.problem, 2, 2, 0.1, 0.1)});
    const ControlBounds bounds(problem);
    Linearization linearization(problem);
    RandomNumbers random(seed);
    randomize(problem, random, linearization);
    const int m = problem.constraint_rows(), controls = bounds.size();
    Trajectory trajectory = random_guess(problem, seed);
    bounds.clamp(trajectory);
    Gaps gaps(problem);
    gaps.set(linearization, true);
    Adjoint adjoint(problem, bounds);

    const DenseHorizon plain(linearization, true);
    const Eigen::MatrixXd C = dense_constraints(problem, linearization);
    SmallQp qp{.H = plain.S.transpose() * plain.H * plain.S,
               .g = plain.S.transpose() * (plain.H * plain.s + plain.g),
               .A = Eigen::MatrixXd(m + controls, controls),
               .lower = Eigen::VectorXd(m + controls),
               .upper = Eigen::VectorXd(m + controls)};
    qp.A << C * plain.S, Eigen::MatrixXd::Identity(controls, controls);
    // A random motion satisfies the rows, so a solution exists.
    Eigen::VectorXd known(controls);
    for (int k = 0; k < problem.knots(); ++k)
      for (int i = 0; i < problem.nu(k); ++i)
        known[bounds.offset(k) + i] =
            random.uniform(bounds.lower(k)[i], bounds.upper(k)[i]) - trajectory.u(k)[i];
    const Eigen::VectorXd kept = C * (plain.S * known + plain.s);
    for (const NodeConstraint& c : problem.constraints())
      linearization.constraint[c.row] = random.uniform(c.lower[0], c.upper[0]) - kept[c.row];
    const Eigen::VectorXd value = linearization.constraint + C * plain.s;
    for (const NodeConstraint& c : problem.constraints()) {
      qp.lower[c.row] = c.lower[0] - value[c.row];
      qp.upper[c.row] = c.upper[0] - value[c.row];
    }
    for (int k = 0; k < problem.knots(); ++k) {
      const int at = m + bounds.offset(k), nu = problem.nu(k);
      qp.lower.segment(at, nu) = bounds.lower(k) - trajectory.u(k);
      qp.upper.segment(at, nu) = bounds.upper(k) - trajectory.u(k);
    }
    const SmallQpOptimum optimum = enumerate_active_sets(qp);

    HorizonQp horizon(problem, bounds, box_stage(problem), true, true);
    Eigen::VectorXd multipliers = Eigen::VectorXd::Zero(m);
    horizon.rows().choose(linearization, Eigen::VectorXd::Constant(m, kPenalty), multipliers);
    adjoint.compute(linearization, trajectory, gaps, Feedback(problem));
    ASSERT_TRUE(
        horizon.satisfy({linearization, trajectory, gaps, adjoint.gradient()}, 1e5, multipliers));
    sweeps += horizon.sweeps();
    if (!horizon.within_bounds()) {
      ++cycles;
      continue;
    }
    const Eigen::VectorXd z = plain.S * optimum.x + plain.s;
    EXPECT_LT((plain.stack(horizon.step().z()) - z).lpNorm<Eigen::Infinity>(), 1e-8);
    EXPECT_LT((multipliers - optimum.multipliers.head(m)).lpNorm<Eigen::Infinity>(), 1e-6);
    EXPECT_EQ(horizon.rows().active_rows() + horizon.active_set().clamped_controls(),
              (optimum.multipliers.array() != 0).count());
    rows_held += static_cast<int>((optimum.multipliers.head(m).array() != 0).count()) - 1;
    bounds_held += static_cast<int>((optimum.multipliers.tail(controls).array() != 0).count());
  }
  EXPECT_GT(rows_held, 8);
  EXPECT_GT(bounds_held, 8);
  EXPECT_GT(sweeps, 60);
  EXPECT_LE(cycles, 3) << "which sets that are revised at once may end in";
}

}  // namespace
}  // namespace conddp::testing
