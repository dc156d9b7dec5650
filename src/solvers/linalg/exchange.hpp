#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// Exchanges the memory of matrices of one shape; others keep theirs.
inline void exchange(Eigen::MatrixXd& a, Eigen::MatrixXd& b) {
  if (a.rows() == b.rows() && a.cols() == b.cols()) a.swap(b);
}

/// The same place by place, as far as both have one.
inline void exchange(std::vector<Eigen::MatrixXd>& a, std::vector<Eigen::MatrixXd>& b) {
  for (std::size_t i = 0; i < std::min(a.size(), b.size()); ++i) exchange(a[i], b[i]);
}

}  // namespace conddp
