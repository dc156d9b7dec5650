#pragma once

#include <Eigen/Core>

namespace conddp {

/// out = a b for knot-sized matrices, without packing, copies or allocation beyond that of `out`.
/// `out` must be neither factor. Each entry is a single sum in ascending order of k.
void multiply(const Eigen::Ref<const Eigen::MatrixXd>& a,
              const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::MatrixXd& out);

/// The same for a square product if only its lower triangle is needed.
void multiply_lower(const Eigen::Ref<const Eigen::MatrixXd>& a,
                    const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::MatrixXd& out);

/// Copies the lower triangle of a square matrix to the upper one.
void mirror_lower_triangle(Eigen::MatrixXd& matrix);

/// value += Aᵀ x and size += |A|ᵀ |x|, the sum of the absolute terms. `x` has one number per row of
/// A.
void add_transposed_product(const Eigen::MatrixXd& A, const double* x, Eigen::VectorXd& value,
                            Eigen::VectorXd& size);

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
