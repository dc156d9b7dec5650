#pragma once

#include <Eigen/Core>

namespace conddp {

/// Products of a knot's matrix with a vector, in whole lanes with masked ends, for passes along the
/// horizon. `y` must not overlap with `x`; the inner dimension may be zero.

/// y ← A x.
void multiply(const Eigen::MatrixXd& A, const double* x, double* y);
/// y ← y + A x.
void multiply_add(const Eigen::MatrixXd& A, const double* x, double* y);
/// y ← Aᵀ x.
void multiply_transposed(const Eigen::MatrixXd& A, const double* x, double* y);

}  // namespace conddp
