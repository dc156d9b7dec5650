#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Exchanges the memory of two matrices of the same shape; does nothing for other shapes.
inline void exchange(Eigen::MatrixXd& a, Eigen::MatrixXd& b) {
  if (a.rows() == b.rows() && a.cols() == b.cols()) a.swap(b);
}

/// The same for each pair of matrices at the same position.
inline void exchange(std::vector<Eigen::MatrixXd>& a, std::vector<Eigen::MatrixXd>& b) {
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) exchange(a[i], b[i]);
}

}  // namespace conddp
