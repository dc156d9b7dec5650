#include "analysis/certificate/small_matrices.hpp"

#include <limits>

#include <Eigen/Cholesky>
#include <gtest/gtest.h>

namespace conddp {
namespace {

using Eigen::MatrixXd;

MatrixXd positive_definite(int n) {
  const MatrixXd root = MatrixXd::Random(n, n);
  return root * root.transpose() + 0.1 * MatrixXd::Identity(n, n);
}

TEST(SmallCholesky, SolvesForAllRightHandSides) {
  std::srand(1);
  SmallCholesky factors;
  for (const int n : {0, 1, 2, 3, 7, 8, 9, 20})
    for (const int columns : {0, 1, 5, 8, 21, 50}) {
      MatrixXd A = positive_definite(n);
      const MatrixXd rhs = MatrixXd::Random(n, columns);
      SmallCholesky::Rows solution = rhs;
      const MatrixXd full = A;
      A.triangularView<Eigen::StrictlyUpper>().setConstant(1e9);  // not read
      ASSERT_TRUE(factors.factorize(A, 1e-14)) << n;
      factors.solve(solution);
      if (rhs.size() > 0) {
        EXPECT_LE((full * solution - rhs).cwiseAbs().maxCoeff(), 1e-12) << n << ' ' << columns;
      }
    }
}

TEST(SmallCholesky, RejectsPivotsThatAreTooSmall) {
  SmallCholesky factors;
  const auto has = [&](double first, double second, double least) {
    return factors.factorize(Eigen::Vector2d(first, second).asDiagonal().toDenseMatrix(), least);
  };
  EXPECT_TRUE(has(1, 2e-14, 1e-14));
  EXPECT_FALSE(has(1, 0.5e-14, 1e-14));
  EXPECT_FALSE(has(0.5e-14, 1, 1e-14));
  EXPECT_FALSE(has(0, 0, 1e-14));
  EXPECT_FALSE(has(-1, -1, 1e-14));
  EXPECT_FALSE(has(1, std::numeric_limits<double>::quiet_NaN(), 1e-14));
  EXPECT_FALSE(has(std::numeric_limits<double>::quiet_NaN(), 1, 1e-14));
  // The second pivot is 4 − 2 · 2.
  EXPECT_FALSE(factors.factorize((MatrixXd(2, 2) << 1, 0, 2, 4).finished(), 1e-14));
}

TEST(SmallProducts, MatchEigenForAllSizes) {
  std::srand(1);
  MatrixXd product;
  for (const int rows : {0, 1, 2, 3, 4, 7, 8, 9, 14, 16, 37})
    for (const int columns : {0, 1, 2, 3, 5, 8, 11, 21, 48})
      for (const int terms : {0, 1, 6, 14}) {
        const MatrixXd a = MatrixXd::Random(rows, terms), b = MatrixXd::Random(terms, columns);
        multiply(a, b, product);
        ASSERT_EQ(product.rows(), rows);
        ASSERT_EQ(product.cols(), columns);
        if (product.size() > 0) {
          EXPECT_LE((product - a * b).cwiseAbs().maxCoeff(), 1e-14)
              << rows << " x " << terms << " x " << columns;
        }
      }
}

TEST(SmallProducts, TakeBlocksOfMatrices) {
  std::srand(2);
  const MatrixXd a = MatrixXd::Random(20, 20), b = MatrixXd::Random(20, 20);
  MatrixXd product;
  multiply(a.block(3, 2, 9, 7), b.block(1, 4, 7, 5), product);
  EXPECT_LE((product - a.block(3, 2, 9, 7) * b.block(1, 4, 7, 5)).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(SmallProducts, SymmetricHalfGivesTheOtherHalf) {
  std::srand(4);
  MatrixXd product;
  for (const int size : {0, 1, 2, 3, 7, 8, 9, 14, 21, 37, 48}) {
    const MatrixXd a = MatrixXd::Random(size, 6), b = a.transpose();
    multiply_lower(a, b, product);
    mirror_lower_triangle(product);
    EXPECT_EQ(product, product.transpose());
    EXPECT_LE((product - a * b).norm(), 1e-13) << size;
  }
}

TEST(SmallProducts, AddTransposedProductsAndTermSizes) {
  std::srand(3);
  for (const int rows : {0, 1, 3, 8, 9, 14, 37})
    for (const int columns : {0, 1, 7, 8, 21}) {
      const MatrixXd A = MatrixXd::Random(rows, columns);
      const Eigen::VectorXd x = Eigen::VectorXd::Random(rows);
      const Eigen::VectorXd first = Eigen::VectorXd::Random(columns);
      Eigen::VectorXd value = first, size = 2 * first;
      add_transposed_product(A, x.data(), value, size);
      const Eigen::VectorXd expected = first + A.transpose() * x;
      const Eigen::VectorXd sizes = 2 * first + A.cwiseAbs().transpose() * x.cwiseAbs();
      EXPECT_LE((value - expected).norm(), 1e-14) << rows << " x " << columns;
      EXPECT_LE((size - sizes).norm(), 1e-13) << rows << " x " << columns;
    }
}

}  // namespace
}  // namespace conddp
