#pragma once

#include <Eigen/Core>

namespace conddp {

/// Cholesky factor L of a knot-sized symmetric matrix A = L Lᵀ, and solutions for right-hand sides
/// side by side.
class SmallCholesky {
 public:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

  /// Factorizes A from its lower triangle. Returns false, without a factor, if a pivot is not
  /// positive or not above `least` times the largest entry of the diagonal.
  bool factorize(const Eigen::Ref<const Eigen::MatrixXd>& A, double least);
  /// rhs ← A⁻¹ rhs.
  void solve(Rows& rhs) const;

 private:
  Eigen::MatrixXd L_;
  Eigen::VectorXd inverse_;  ///< inverse of the diagonal of L
};

}  // namespace conddp
