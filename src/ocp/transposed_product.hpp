#pragma once

#include <Eigen/Core>

namespace conddp {

/// out = Aᵀ x, a lane of columns at a time.
void multiply_transposed(const Eigen::MatrixXd& A, const double* x, double* out);

}  // namespace conddp
