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

}  // namespace
}  // namespace conddp
