#include "solvers/linalg/low_rank_update.hpp"

#include <algorithm>

namespace conddp {
namespace {

/// H += A Bᵀ with n columns `stride` apart, one column of H at a time.
template <int n>
void add_products(const double* A, const double* B, int stride, Eigen::MatrixXd& H) {
  const int size = static_cast<int>(H.rows());
  for (int j = 0; j < size; ++j) {
    double* h = H.data() + j * size;
    double b[n];
    for (int r = 0; r < n; ++r) b[r] = B[r * stride + j];
    for (int i = 0; i < size; ++i) {
      double sum = h[i];
      for (int r = 0; r < n; ++r) sum += A[r * stride + i] * b[r];
      h[i] = sum;
    }
  }
}

}  // namespace

LowRankUpdate::LowRankUpdate(const ShootingProblem& problem) {
  int rows = 0, columns = 0;
  for (int k = 0; k <= problem.knots(); ++k) {
    rows = std::max(rows, problem.constraint_offset(k + 1) - problem.constraint_offset(k));
    columns = std::max(columns, problem.knot(k).model->nz());
  }
  rows_.setZero(columns, rows);
  weighted_.setZero(columns, rows);
}

void LowRankUpdate::add(const Eigen::Ref<const Eigen::MatrixXd>& C,
                        const Eigen::Ref<const Eigen::MatrixXd>& W) {
  const int n = static_cast<int>(C.rows());
  auto rows = rows_.block(0, count_, C.cols(), n);
  auto weighted = weighted_.block(0, count_, C.cols(), n);
  for (int i = 0; i < n; ++i) rows.col(i) = C.row(i);
  for (int i = 0; i < n; ++i) {
    weighted.col(i) = W(0, i) * rows.col(0);
    for (int r = 1; r < n; ++r) weighted.col(i) += W(r, i) * rows.col(r);
  }
  count_ += n;
}

void LowRankUpdate::apply(KnotHessian& hessian) {
  Eigen::MatrixXd& H = hessian.change(std::max(hessian.fill(), HessianFill::pattern));
  const int stride = static_cast<int>(rows_.rows());
  int done = 0;
  const auto take = [&](auto products, int n) {
    products(rows_.data() + done * stride, weighted_.data() + done * stride, stride, H);
    done += n;
  };
  while (count_ - done >= 6) take(add_products<6>, 6);
  while (count_ - done >= 3) take(add_products<3>, 3);
  while (done < count_) take(add_products<1>, 1);
  count_ = 0;
}

}  // namespace conddp
