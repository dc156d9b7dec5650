#include "solvers/cholesky.hpp"

#include <cmath>
#include <limits>

namespace conddp {
namespace {

/// y ← y − a x.
inline void subtract(int n, double a, const double* __restrict x, double* __restrict y) {
  for (int i = 0; i < n; ++i) y[i] -= a * x[i];
}

inline void scale(int n, double a, double* x) {
  for (int i = 0; i < n; ++i) x[i] *= a;
}

}  // namespace

bool cholesky_in_place(Eigen::Ref<Eigen::MatrixXd> A) {
  const int n = static_cast<int>(A.rows());
  for (int j = 0; j < n; ++j) {
    double* column = &A(j, j);
    double subtracted = 0;
    for (int i = 0; i < j; ++i) subtracted += A(j, i) * A(j, i);
    const double pivot = column[0] - subtracted;
    // A pivot that cancellation left is noise, and so would be the gains that it gives.
    const double rounding = 4 * std::numeric_limits<double>::epsilon() * subtracted;
    if (!(pivot > rounding) || !std::isfinite(pivot)) return false;
    for (int i = 0; i < j; ++i) subtract(n - j - 1, A(j, i), &A(j, i) + 1, column + 1);
    column[0] = std::sqrt(pivot);
    scale(n - j - 1, 1 / column[0], column + 1);
  }
  return true;
}

void solve_rows_in_place(const Eigen::Ref<const Eigen::MatrixXd>& L,
                         Eigen::Ref<Eigen::MatrixXd> B) {
  const int n = static_cast<int>(L.rows());
  const int rows = static_cast<int>(B.rows());
  for (int j = 0; j < n; ++j) {
    double* column = B.col(j).data();
    for (int i = 0; i < j; ++i) subtract(rows, L(j, i), B.col(i).data(), column);
    scale(rows, 1 / L(j, j), column);
  }
  for (int j = n - 1; j >= 0; --j) {
    double* column = B.col(j).data();
    for (int i = j + 1; i < n; ++i) subtract(rows, L(i, j), B.col(i).data(), column);
    scale(rows, 1 / L(j, j), column);
  }
}

}  // namespace conddp
