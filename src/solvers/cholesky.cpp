#include "solvers/cholesky.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "solvers/lane_gemm.hpp"

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

void solve_rows_in_place(const Eigen::Ref<const Eigen::MatrixXd>& L, LaneBlock B) {
  constexpr int kBlock = 6;
  const int n = static_cast<int>(L.rows());
  const int stride = static_cast<int>(L.outerStride());
  const int rows = (B.rows + kLaneWidth - 1) / kLaneWidth * kLaneWidth;
  const auto column = [&](int j) { return B.data + j * B.stride; };
  const auto columns = [&](int first, int count) {
    return LaneBlock{column(first), B.stride, B.rows, count};
  };
  // Y Lᵀ = B, then X L = Y: a block of columns first loses what the finished ones contribute.
  for (int first = 0; first < n; first += kBlock) {
    const int end = std::min(n, first + kBlock);
    multiply(Store::subtract, columns(first, end - first), columns(0, first),
             {L.data() + first, stride, 1});
    for (int j = first; j < end; ++j) {
      for (int i = first; i < j; ++i) subtract(rows, L(j, i), column(i), column(j));
      scale(rows, 1 / L(j, j), column(j));
    }
  }
  for (int first = (n - 1) / kBlock * kBlock; first >= 0; first -= kBlock) {
    const int end = std::min(n, first + kBlock);
    multiply(Store::subtract, columns(first, end - first), columns(end, n - end),
             {L.data() + end + first * stride, 1, stride});
    for (int j = end - 1; j >= first; --j) {
      for (int i = j + 1; i < end; ++i) subtract(rows, L(i, j), column(i), column(j));
      scale(rows, 1 / L(j, j), column(j));
    }
  }
}

}  // namespace conddp
