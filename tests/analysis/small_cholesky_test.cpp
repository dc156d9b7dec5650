#include "analysis/certificate/small_cholesky.hpp"

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

}  // namespace
}  // namespace conddp
