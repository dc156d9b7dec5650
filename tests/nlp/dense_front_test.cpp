#include "nlp/dense_front.hpp"

#include <Eigen/Dense>
#include <gtest/gtest.h>

namespace conddp {
namespace {

constexpr double kFrontTolerance = 0.1;

/// Symmetric and indefinite, with zero diagonals.
Eigen::MatrixXd indefinite(int size, unsigned seed) {
  std::srand(seed);
  Eigen::MatrixXd A = Eigen::MatrixXd::Random(size, size);
  A = (A + A.transpose()).eval();
  for (int i = 0; i < size; i += 2) A(i, i) = 0;
  return A;
}

DenseFront front_of(const Eigen::MatrixXd& A, int candidates) {
  DenseFront front;
  const int size = static_cast<int>(A.rows());
  front.reset(candidates, size);
  for (int c = 0; c < size; ++c) {
    front.names()[static_cast<std::size_t>(c)] = c;
    for (int r = c; r < size; ++r) front.at(r, c) = A(r, c);
  }
  return front;
}

/// A with its rows in the order of the front.
Eigen::MatrixXd reordered(const Eigen::MatrixXd& A, const DenseFront& front) {
  Eigen::MatrixXd result(A.rows(), A.cols());
  for (int r = 0; r < A.rows(); ++r)
    for (int c = 0; c < A.cols(); ++c)
      result(r, c) =
          A(front.names()[static_cast<std::size_t>(r)], front.names()[static_cast<std::size_t>(c)]);
  return result;
}

Eigen::MatrixXd factor_of(const DenseFront& front) {
  Eigen::MatrixXd L = Eigen::MatrixXd::Zero(front.size(), front.pivots());
  for (int c = 0; c < front.pivots(); ++c) {
    L(c, c) = 1;
    for (int r = c + 1; r < front.size(); ++r) L(r, c) = front.at(r, c);
  }
  return L;
}

Eigen::MatrixXd diagonal_of(const DenseFront& front) {
  Eigen::MatrixXd D = Eigen::MatrixXd::Zero(front.pivots(), front.pivots());
  for (int c = 0; c < front.pivots(); ++c) {
    D(c, c) = front.pivot(c).value;
    if (front.pivot(c).coupling != 0) D(c, c + 1) = D(c + 1, c) = front.pivot(c).coupling;
  }
  return D;
}

Eigen::MatrixXd schur_of(const DenseFront& front) {
  const int rest = front.size() - front.pivots();
  Eigen::MatrixXd S(rest, rest);
  for (int r = 0; r < rest; ++r)
    for (int c = 0; c <= r; ++c)
      S(r, c) = S(c, r) = front.at(front.pivots() + r, front.pivots() + c);
  return S;
}

class Fronts : public ::testing::TestWithParam<int> {};

TEST_P(Fronts, AreProductsOfTheirFactors) {
  const Eigen::MatrixXd A = indefinite(GetParam(), 3);
  DenseFront front = front_of(A, GetParam());
  front.eliminate(kFrontTolerance);
  ASSERT_EQ(front.pivots(), GetParam());
  const Eigen::MatrixXd L = factor_of(front);
  EXPECT_LE((L * diagonal_of(front) * L.transpose() - reordered(A, front)).norm(), 1e-11);
  const Eigen::VectorXd eigenvalues = A.selfadjointView<Eigen::Lower>().eigenvalues();
  EXPECT_EQ(front.negative(), (eigenvalues.array() < 0).count());
}

TEST_P(Fronts, LeaveTheSchurComplement) {
  const int candidates = GetParam() / 2 + 1;
  const Eigen::MatrixXd A = indefinite(GetParam(), 4);
  DenseFront front = front_of(A, candidates);
  front.eliminate(kFrontTolerance);
  const int done = front.pivots(), rest = front.size() - done;
  ASSERT_GT(done, 0);
  const Eigen::MatrixXd B = reordered(A, front);
  const Eigen::MatrixXd expected =
      B.bottomRightCorner(rest, rest) - B.bottomLeftCorner(rest, done) *
                                            B.topLeftCorner(done, done).inverse() *
                                            B.topRightCorner(done, rest);
  EXPECT_LE((schur_of(front) - expected).norm(), 1e-10 * (1 + expected.norm()));
}

TEST_P(Fronts, FactorsStayWithinThePivotTolerance) {
  DenseFront front = front_of(indefinite(GetParam(), 5), GetParam());
  front.eliminate(kFrontTolerance);
  EXPECT_LE(factor_of(front).lpNorm<Eigen::Infinity>(), 1 / kFrontTolerance);
}

INSTANTIATE_TEST_SUITE_P(Sizes, Fronts, ::testing::Values(2, 3, 5, 8, 17, 40),
                         ::testing::PrintToStringParamName());

TEST(DenseFront, SkipsRelativelySmallPivotCandidates) {
  const Eigen::Matrix2d A{{0.05, 1}, {1, 3}};
  DenseFront front = front_of(A, 1);
  front.eliminate(kFrontTolerance);
  EXPECT_EQ(front.pivots(), 0);
  EXPECT_EQ(schur_of(front), A);
  DenseFront bolder = front_of(A, 1);
  bolder.eliminate(0.04);
  EXPECT_EQ(bolder.pivots(), 1);
  EXPECT_NEAR(bolder.at(1, 1), 3 - 1 / 0.05, 1e-14);
}

TEST(DenseFront, PairsCandidatesOfZeroDiagonal) {
  const Eigen::Matrix3d A{{0, 2, 1}, {2, 0, 4}, {1, 4, 5}};
  DenseFront front = front_of(A, 2);
  front.eliminate(kFrontTolerance);
  ASSERT_EQ(front.pivots(), 2);
  EXPECT_EQ(front.pivot(0).coupling, 2);
  EXPECT_EQ(front.negative(), 1);
  EXPECT_NEAR(front.at(2, 2), 5 - 2 * 1 * 4 / 2.0, 1e-15);
}

TEST(DenseFront, CountsBothNegativeEigenvaluesOfAPair) {
  // The first pivot is small compared with its coupling to the second; as a pair they are definite.
  const Eigen::Matrix3d A{{-1, 3, 0.1}, {3, -10, 0.1}, {0.1, 0.1, 1}};
  DenseFront front = front_of(A, 2);
  front.eliminate(0.5);
  ASSERT_EQ(front.pivots(), 2);
  EXPECT_EQ(front.pivot(0).coupling, 3);
  EXPECT_EQ(front.negative(), 2);
}

TEST(DenseFront, FindsNoPivotInASingularRemainder) {
  const Eigen::Matrix3d A{{1, 2, 3}, {2, 4, 6}, {3, 6, 9}};
  DenseFront front = front_of(A, 3);
  front.eliminate(kFrontTolerance);
  EXPECT_EQ(front.pivots(), 1);
}

}  // namespace
}  // namespace conddp
