#pragma once

#include <Eigen/Core>

namespace conddp {

/// out = a b, of matrices with the size of a knot: without packing, copies or allocation beyond
/// that of `out`. `out` is neither factor. Each entry is one sum over k from the first on.
void multiply(const Eigen::Ref<const Eigen::MatrixXd>& a,
              const Eigen::Ref<const Eigen::MatrixXd>& b, Eigen::MatrixXd& out);

}  // namespace conddp
