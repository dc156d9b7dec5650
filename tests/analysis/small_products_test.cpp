#include "analysis/certificate/small_products.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

using Eigen::MatrixXd;

TEST(SmallProducts, AreThoseOfEigenForAllSizes) {
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

}  // namespace
}  // namespace conddp
