#pragma once

#include <Eigen/Core>

namespace conddp {

/// out = a b, of matrices with the size of a knot: without packing, copies or allocation beyond
/// that of `out`. `out` is neither factor. Each entry is one sum over k from the first on.
void multiply(const Eigen::Ref<const Eigen::MatrixXd>& a,
              const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::MatrixXd& out);

/// The same of a square product, of which only the lower triangle is needed.
void multiply_lower(const Eigen::Ref<const Eigen::MatrixXd>& a,
                    const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::MatrixXd& out);

/// Makes a square matrix symmetric: what is above the diagonal becomes what is below it.
void mirror_lower_triangle(Eigen::MatrixXd& matrix);

/// value += Aᵀ x, and size += |A|ᵀ |x|, what the terms of each sum add up to without their signs.
/// `x` has a number for each row of A.
void add_transposed_product(const Eigen::MatrixXd& A, const double* x, Eigen::VectorXd& value,
                            Eigen::VectorXd& size);

}  // namespace conddp
