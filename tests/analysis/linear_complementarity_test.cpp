#include "analysis/contact/linear_complementarity.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/random_numbers.hpp"

namespace conddp {
namespace {

void expect_solution(const Eigen::MatrixXd& M, const Eigen::VectorXd& q) {
  const auto z = solve_lcp(M, q);
  ASSERT_TRUE(z);
  const Eigen::VectorXd w = M * *z + q;
  EXPECT_GE(z->minCoeff(), 0);
  EXPECT_LT(z->cwiseMin(w).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(LinearComplementarity, PositiveDefiniteProblems) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (int n = 1; n < 20; ++n) {
    const Eigen::MatrixXd a = Eigen::MatrixXd::NullaryExpr(n, n, [&] { return normal(random); });
    const Eigen::VectorXd q = Eigen::VectorXd::NullaryExpr(n, [&] { return normal(random); });
    expect_solution(a * a.transpose() + 0.1 * Eigen::MatrixXd::Identity(n, n), q);
  }
}

/// Duplicate rows, as contacts that constrain the same motion produce them.
TEST(LinearComplementarity, RedundantRowsDoNotCycle) {
  std::mt19937 random(5);
  std::normal_distribution<double> normal;
  for (int rank = 1; rank < 5; ++rank) {
    Eigen::MatrixXd rows(4 * rank, rank);
    const Eigen::MatrixXd some =
        Eigen::MatrixXd::NullaryExpr(rank, rank, [&] { return normal(random); });
    rows << some, some, some, 2 * some;
    const Eigen::VectorXd speed = -Eigen::VectorXd::Ones(rank);
    Eigen::VectorXd q(4 * rank);
    q << speed, speed, speed, 2 * speed;
    expect_solution(rows * rows.transpose(), q);
  }
}

TEST(LinearComplementarity, ReportsProblemsWithoutSolution) {
  // w = −z − 1 is never positive.
  EXPECT_FALSE(solve_lcp(-Eigen::MatrixXd::Identity(1, 1), -Eigen::VectorXd::Ones(1)));
  EXPECT_FALSE(solve_lcp(Eigen::MatrixXd::Zero(2, 2), -Eigen::VectorXd::Ones(2)));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(solve_lcp(Eigen::MatrixXd::Identity(1, 1), Eigen::VectorXd::Constant(1, nan)));
}

TEST(LinearComplementarity, NonFiniteInputHasNoSolution) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Eigen::MatrixXd M = Eigen::MatrixXd::Identity(2, 2);
  M(0, 1) = nan;
  EXPECT_FALSE(solve_lcp(M, Eigen::VectorXd::Ones(2)));  // z = 0 would solve it
  const auto none = solve_lcp(Eigen::MatrixXd(0, 0), Eigen::VectorXd(0));
  ASSERT_TRUE(none);
  EXPECT_EQ(none->size(), 0);
}

TEST(LinearComplementarity, UnneededImpulsesAreZero) {
  const auto z = solve_lcp(-Eigen::MatrixXd::Identity(2, 2), Eigen::Vector2d(0, 3));
  ASSERT_TRUE(z);
  EXPECT_EQ(*z, Eigen::VectorXd::Zero(2));
}

/// Small integers produce ties in every pivoting step.
TEST(LinearComplementarity, TiesDoNotCycle) {
  RandomNumbers random(9);
  for (int i = 0; i < 3000; ++i) {
    const int n = 2 + random.index(5), rank = 1 + random.index(n);
    Eigen::MatrixXd a(n, rank);
    for (double& entry : a.reshaped()) entry = random.index(3) - 1;
    Eigen::VectorXd wanted(rank);
    for (double& entry : wanted) entry = random.index(5) - 2;
    // w = a (aᵀ z + wanted) has a solution because it stems from a convex problem.
    expect_solution(a * a.transpose(), a * wanted);
  }
}

Eigen::RowVectorXd row(std::initializer_list<double> numbers) {
  Eigen::RowVectorXd values(numbers.size());
  std::copy(numbers.begin(), numbers.end(), values.data());
  return values;
}

/// A contact with a normal and two tangents in three velocities; the first velocity is normal.
ContactPairs contact(const Eigen::VectorXd& v, double friction) {
  ContactPairs pairs(6, 3);
  const int normal = pairs.add(0.25, row({1, 0, 0}), row({1, 0, 0}));
  Eigen::MatrixXd tangents(2, 3);
  tangents << 0, 1, 0, 0, 0, 1;
  pairs.add_friction(tangents, 2 * tangents, v, {.factor = friction, .normal = normal});
  return pairs;
}

TEST(ContactPairs, FrictionHasSignedTangentsAndSpeedSlack) {
  const ContactPairs pairs = contact(Eigen::Vector3d(5, 0.5, -0.25), 0.8);
  EXPECT_EQ(pairs.value, (Eigen::VectorXd(6) << 0.25, 0.5, -0.5, -0.25, 0.25, 0).finished());
  EXPECT_EQ(pairs.push.row(2), row({0, -1, 0}));
  EXPECT_EQ(pairs.slope.row(2), row({0, -2, 0}));
  EXPECT_EQ(pairs.budget, std::vector<bool>({false, false, false, false, false, true}));
}

TEST(ContactPairs, FrictionStaysWithinNormalImpulseBudget) {
  const ContactPairs pairs = contact(Eigen::Vector3d::Zero(), 0.8);
  // z: normal impulse 2, friction impulses 0.5 and 0.25 along the edges.
  const Eigen::VectorXd z = (Eigen::VectorXd(6) << 2, 0.5, 0, 0, 0.25, 3).finished();
  const Eigen::VectorXd w = pairs.value + pairs.coupling * z;
  EXPECT_DOUBLE_EQ(w[5], 0.8 * 2 - 0.75);
  // The speed slack appears in each edge.
  for (int edge = 1; edge < 5; ++edge) EXPECT_DOUBLE_EQ(w[edge], 3);
  EXPECT_DOUBLE_EQ(w[0], 0.25);
}

TEST(ContactPairs, ConstantBudgetNeedsNoNormal) {
  ContactPairs pairs(3, 1);
  pairs.add_friction(row({1}), row({1}), Eigen::VectorXd::Ones(1), {.constant = 0.5});
  EXPECT_DOUBLE_EQ(pairs.value[2], 0.5);
  EXPECT_TRUE(pairs.coupling.row(2).isApprox(row({-1, -1, 0})));
}

TEST(ContactPairs, SlowestEdgeHasTheLeastSpeed) {
  const ContactPairs pairs = contact(Eigen::Vector3d(0, 0.5, -0.75), 0.8);
  EXPECT_EQ(pairs.slowest_edge(5, pairs.value), 3);
  EXPECT_EQ(pairs.slowest_edge(0, pairs.value), std::nullopt);
}

TEST(ContactPairs, AtRestHaveNoEffect) {
  ContactPairs pairs(3, 1);
  pairs.rest(2);
  EXPECT_EQ(pairs.add(4, row({1}), row({1})), 2);
  EXPECT_EQ(pairs.value, Eigen::Vector3d(1, 1, 4));
  EXPECT_TRUE(pairs.push.topRows(2).isZero(0));
  EXPECT_TRUE(pairs.coupling.isZero(0));
}

}  // namespace
}  // namespace conddp
