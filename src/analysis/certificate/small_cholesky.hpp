#pragma once

#include <Eigen/Core>

namespace conddp {

/// The factor L of a symmetric matrix A = L Lᵀ with the size of a knot, and solutions for
/// right-hand sides that stand side by side.
class SmallCholesky {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// From the lower triangle of A. False where a pivot is not positive, or not above `least` times
  /// the largest entry of the diagonal; then there is no factor.
  bool factorize(const Eigen::Ref<const Eigen::MatrixXd>& A, double least);
  /// rhs ← A⁻¹ rhs.
  void solve(Rows& rhs) const;

 private:
  Eigen::MatrixXd L_;
  Eigen::VectorXd inverse_;  ///< of its diagonal
};

}  // namespace conddp
