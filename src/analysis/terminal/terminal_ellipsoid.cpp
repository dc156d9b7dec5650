#include "analysis/terminal/terminal_ellipsoid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/matrix_decompositions.hpp"

namespace conddp {
namespace {

/// In the solution of an equation, values below this share of the largest of n numbers are
/// rounding.
double rounding(int n) { return 16 * n * std::numeric_limits<double>::epsilon(); }

/// Square roots of the diagonal; 0 if they are rounding.
Eigen::VectorXd scale_of(const Eigen::MatrixXd& matrix) {
  const Eigen::VectorXd scale = matrix.diagonal().cwiseMax(0.0).cwiseSqrt();
  const double least = rounding(static_cast<int>(scale.size())) * scale.maxCoeff();
  return scale.unaryExpr([least](double s) { return s > least ? s : 0.0; });
}

}  // namespace

Eigen::MatrixXd without_rounding(const Eigen::MatrixXd& matrix) {
  const int n = static_cast<int>(matrix.rows());
  const Eigen::VectorXd scale = scale_of(matrix);
  const Eigen::VectorXd inverse = scale.unaryExpr([](double s) { return s > 0 ? 1 / s : 0.0; });
  const Eigen::MatrixXd scaled = inverse.asDiagonal() * matrix * inverse.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
  const int rank = static_cast<int>((eigen.eigenvalues().array() > rounding(n)).count());
  if (rank == n) return matrix;
  const Eigen::MatrixXd L = scale.asDiagonal() * eigen.eigenvectors().rightCols(rank) *
                            eigen.eigenvalues().tail(rank).cwiseSqrt().asDiagonal();
  const Eigen::MatrixXd product = L * L.transpose();
  return 0.5 * (product + product.transpose());
}

TerminalEllipsoid terminal_ellipsoid(const Eigen::MatrixXd& P) {
  const int n = static_cast<int>(P.rows());
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(P);
  const Eigen::VectorXd& values = eigen.eigenvalues();  // ascending
  const double least = rounding(n) * std::max(values[n - 1], 0.0);
  const int rank = static_cast<int>((values.array() > least).count());
  return {eigen.eigenvectors().rightCols(rank) *
              values.tail(rank).cwiseSqrt().cwiseInverse().asDiagonal(),
          eigen.eigenvectors().leftCols(n - rank)};
}

}  // namespace conddp
