#include "analysis/certificate/small_cholesky.hpp"

#include <algorithm>
#include <cmath>

namespace conddp {
namespace {

using Eigen::Index;

/// to −= factor · from.
void subtract(double factor, const double* from, Index count, double* to) {
  for (Index i = 0; i < count; ++i) to[i] -= factor * from[i];
}

void scale(double factor, Index count, double* numbers) {
  for (Index i = 0; i < count; ++i) numbers[i] *= factor;
}

}  // namespace

bool SmallCholesky::factorize(const Eigen::Ref<const Eigen::MatrixXd>& A, double least) {
  const Index n = A.rows();
  L_ = A;
  inverse_.resize(n);
  const double threshold = least * std::max(0.0, n == 0 ? 0.0 : A.diagonal().maxCoeff());
  for (Index k = 0; k < n; ++k) {
    const double pivot = L_(k, k);
    if (!(pivot > 0) || !(pivot > threshold)) return false;
    inverse_[k] = 1 / std::sqrt(pivot);
    double* column = L_.col(k).data();
    scale(inverse_[k], n - k, column + k);
    for (Index j = k + 1; j < n; ++j) subtract(column[j], column + j, n - j, &L_(j, j));
  }
  return true;
}

void SmallCholesky::solve(Rows& rhs) const {
  const Index n = L_.rows(), width = rhs.cols();
  for (Index i = 0; i < n; ++i) {
    double* row = rhs.row(i).data();
    for (Index k = 0; k < i; ++k) subtract(L_(i, k), rhs.row(k).data(), width, row);
    scale(inverse_[i], width, row);
  }
  for (Index i = n - 1; i >= 0; --i) {
    double* row = rhs.row(i).data();
    for (Index k = i + 1; k < n; ++k) subtract(L_(k, i), rhs.row(k).data(), width, row);
    scale(inverse_[i], width, row);
  }
}

}  // namespace conddp
