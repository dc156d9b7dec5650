#include "solvers/linalg/lane_gemm.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "solvers/linalg/curved_blocks.hpp"
#include "solvers/linalg/lane_copy.hpp"

// Products of the sweep, compared with Eigen's for all tile shapes.

namespace conddp {
namespace {

/// Integers whose products and sums are exact: results equal Eigen's to the last bit.
Eigen::MatrixXd whole_numbers(int rows, int cols, int seed) {
  Eigen::MatrixXd A(rows, cols);
  for (int j = 0; j < cols; ++j)
    for (int i = 0; i < rows; ++i) A(i, j) = (31 * i + 17 * j + 7 * seed + i * j) % 23 - 11;
  return A;
}

/// Larger than the matrix, so that columns have a separate stride, and padded with garbage.
LaneMatrix lanes_of(const Eigen::MatrixXd& A) {
  const int rows = static_cast<int>(A.rows()), cols = static_cast<int>(A.cols());
  LaneMatrix lanes(rows + 3, cols + 1);
  lanes.view().setConstant(1e300);
  lanes.resize(rows, cols);
  lanes.view() = A;
  return lanes;
}

constexpr int kRows[] = {1, 3, 4, 7, 8, 9, 14, 16, 21, 36, 41, 76};

TEST(LaneGemm, ProductsMatchEigen) {
  for (const int m : kRows)
    for (int n = 1; n <= 13; ++n)
      for (const int inner : {0, 1, 5, 18}) {
        const Eigen::MatrixXd A = whole_numbers(m, inner, 1), B = whole_numbers(inner, n, 2);
        const Eigen::MatrixXd C = whole_numbers(m, n, 3);
        LaneMatrix lanes_A = lanes_of(A), lanes_Bt = lanes_of(B.transpose());
        LaneMatrix result = lanes_of(C);
        multiply(Store::set, result.block(), lanes_A.block(), Factor::of_eigen(B));
        EXPECT_EQ(result.view(), A * B) << m << ' ' << n << ' ' << inner;
        result = lanes_of(C);
        multiply(Store::add, result.block(), lanes_A.block(), Factor::transposed(lanes_Bt));
        EXPECT_EQ(result.view(), C + A * B) << m << ' ' << n << ' ' << inner;
        result = lanes_of(C);
        multiply(Store::subtract, result.block(), lanes_A.block(), Factor::of_eigen(B));
        EXPECT_EQ(result.view(), C - A * B) << m << ' ' << n << ' ' << inner;
      }
}

TEST(LaneGemm, LowerTriangleAndItsMirrorImage) {
  for (const int n : kRows) {
    const Eigen::MatrixXd A = whole_numbers(n, 6, 1), C = whole_numbers(n, n, 2);
    LaneMatrix lanes_A = lanes_of(A), result = lanes_of(C);
    multiply_lower(Store::add, result.block(), lanes_A.block(), Factor::transposed(lanes_A));
    mirror_lower(result.block());
    const Eigen::MatrixXd expected = C + A * A.transpose();
    EXPECT_EQ(Eigen::MatrixXd(result.view()),
              Eigen::MatrixXd(expected.selfadjointView<Eigen::Lower>()))
        << n;
  }
}

TEST(LaneCopy, SymmetricMatricesFromTheirLowerTriangles) {
  for (const int n : kRows) {
    const Eigen::MatrixXd A = whole_numbers(n, n, 4);
    Eigen::MatrixXd expected = A.selfadjointView<Eigen::Lower>();
    Eigen::MatrixXd copy(n, n);
    LaneMatrix lanes = lanes_of(A);
    for (int j = 1; j < n; ++j) lanes.view().col(j).head(j).setConstant(NAN);
    EXPECT_TRUE(copy_symmetric(lanes.block(), copy.data(), n)) << n;
    EXPECT_EQ(copy, expected) << n;
    for (const int first : {1, n / 2, n - 1}) {
      LaneMatrix half = lanes_of(A);
      mirror_lower(half.block(), first);
      EXPECT_EQ(half.view().rightCols(n - first), expected.rightCols(n - first)) << n;
      EXPECT_EQ(Eigen::MatrixXd(half.view().triangularView<Eigen::Lower>()),
                Eigen::MatrixXd(A.triangularView<Eigen::Lower>()))
          << n;
    }
    for (const double rubbish : {NAN, INFINITY}) {
      lanes.view()(n - 1, n / 2) = rubbish;
      EXPECT_FALSE(copy_symmetric(lanes.block(), copy.data(), n)) << n;
    }
  }
}

TEST(LaneCopy, Transposes) {
  for (const int m : kRows)
    for (const int n : kRows) {
      const Eigen::MatrixXd A = whole_numbers(m, n, 1);
      LaneMatrix result = lanes_of(whole_numbers(n, m, 2));
      transpose(A.data(), m, m, n, result.data(), result.stride());
      EXPECT_EQ(result.view(), A.transpose()) << m << ' ' << n;
    }
}

TEST(CurvedBlocks, TransformOnlyTheirRowsAndColumns) {
  for (const int n : {3, 6})
    for (const int size : {n, 7, 18, 33}) {
      const int at = (size - n) / 2;
      const Eigen::Matrix<double, -1, -1, Eigen::RowMajor> stored = whole_numbers(n, n + 1, 1);
      const CurvedBlock block{stored.data(), n, n + 1};
      Eigen::MatrixXd T = Eigen::MatrixXd::Identity(size, size);
      T.block(at, at, n, n) = stored.leftCols(n);
      const Eigen::MatrixXd A = whole_numbers(size, size, 2);
      Eigen::MatrixXd X = A;
      transform_rows(block, X.data() + at, size, size);
      EXPECT_EQ(X, T.transpose() * A) << n << ' ' << size;
      X = A;
      transform_columns(block, X.col(at).data(), size, size);
      EXPECT_EQ(X, A * T) << n << ' ' << size;
    }
}

}  // namespace
}  // namespace conddp
