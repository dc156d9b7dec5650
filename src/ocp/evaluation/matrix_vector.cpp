#include "ocp/evaluation/matrix_vector.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "spatial/lane_memory.hpp"

namespace conddp {
namespace {

/// Maximum rows per pass through the columns, in lanes: this many sums, twice, stay in registers.
constexpr int kMostLanes = 5;

/// The last lane of a column, with only `count` valid numbers.
template <bool kWhole>
Lane load_end(const double* from, int count) {
  if constexpr (kWhole) return load_lane(from);
  return load_part(from, count);
}

/// A pass over some rows. Even and odd columns have separate sums, which removes a dependency
/// between them.
template <int kLanes, bool kWhole>
void multiply_rows(bool add, const double* A, int stride, int cols, int end, const double* x,
                   double* y) {
  constexpr int kEnd = kLanes - 1;
  Lane even[kLanes], odd[kLanes];
#pragma GCC unroll 8
  for (int l = 0; l < kLanes; ++l) even[l] = odd[l] = Lane(0.0);
  if (add) {
#pragma GCC unroll 8
    for (int l = 0; l < kEnd; ++l) even[l] = load_lane(y + l * kLaneWidth);
    even[kEnd] = load_end<kWhole>(y + kEnd * kLaneWidth, end);
  }
  const auto take = [&](Lane(&sum)[kLanes], const double* column, double factor) {
#pragma GCC unroll 8
    for (int l = 0; l < kEnd; ++l) sum[l] += load_lane(column + l * kLaneWidth) * Lane(factor);
    sum[kEnd] += load_end<kWhole>(column + kEnd * kLaneWidth, end) * Lane(factor);
  };
  int j = 0;
  for (; j + 2 <= cols; j += 2, A += 2 * stride) {
    take(even, A, x[j]);
    take(odd, A + stride, x[j + 1]);
  }
  if (j < cols) take(even, A, x[j]);
#pragma GCC unroll 8
  for (int l = 0; l < kEnd; ++l) store_lane(y + l * kLaneWidth, even[l] + odd[l]);
  const Lane last = even[kEnd] + odd[kEnd];
  if constexpr (kWhole) {
    store_lane(y + kEnd * kLaneWidth, last);
  } else {
    store_part(y + kEnd * kLaneWidth, last, end);
  }
}

using Pass = void (*)(bool, const double*, int, int, int, const double*, double*);

template <bool kWhole, int... kLanes>
constexpr std::array<Pass, kMostLanes> passes(std::integer_sequence<int, kLanes...>) {
  return {multiply_rows<kLanes + 1, kWhole>...};
}

void multiply(bool add, const Eigen::MatrixXd& A, const double* x, double* y) {
  // Indexed by number of lanes − 1.
  constexpr auto kCounts = std::make_integer_sequence<int, kMostLanes>();
  static constexpr auto kWhole = passes<true>(kCounts), kPart = passes<false>(kCounts);
  const int rows = static_cast<int>(A.rows()), cols = static_cast<int>(A.cols());
  for (int row = 0; row < rows; row += kMostLanes * kLaneWidth) {
    const int left = std::min(rows - row, kMostLanes * kLaneWidth);
    const int end = left % kLaneWidth, lanes = left / kLaneWidth + (end > 0 ? 1 : 0);
    (end == 0 ? kWhole : kPart)[lanes - 1](add, A.data() + row, rows, cols, end, x, y + row);
  }
}

/// Lane i of x[0] ← the sum of the lanes of vector i.
template <int kHalf, int... kIndex>
void sum_lanes(Lane (&x)[kLaneWidth], std::integer_sequence<int, kIndex...> lanes) {
#pragma GCC unroll 8
  for (int r = 0; r < kHalf; ++r) {
    const Lane a = x[r], b = x[r + kHalf];
    x[r] = detail::pick<((kIndex & kHalf) != 0 ? kLaneWidth + kIndex - kHalf : kIndex)...>(a, b) +
           detail::pick<((kIndex & kHalf) != 0 ? kLaneWidth + kIndex : kIndex + kHalf)...>(a, b);
  }
  if constexpr (kHalf > 1) sum_lanes<kHalf / 2>(x, lanes);
}

/// Aᵀ x for at most kLaneWidth columns.
template <bool kWhole>
Lane multiply_columns(const double* A, int rows, int cols, const double* x) {
  Lane sum[kLaneWidth];
#pragma GCC unroll 8
  for (int c = 0; c < kLaneWidth; ++c) sum[c] = Lane(0.0);
  const auto take = [&](const double* from, Lane part, auto load) {
#pragma GCC unroll 8
    for (int c = 0; c < kLaneWidth; ++c)
      if (kWhole || c < cols) sum[c] += load(from + c * rows) * part;
  };
  int row = 0;
  for (; row + kLaneWidth <= rows; row += kLaneWidth) take(A + row, load_lane(x + row), load_lane);
  if (const int end = rows - row; end > 0)
    take(A + row, load_part(x + row, end),
         [end](const double* from) { return load_part(from, end); });
  sum_lanes<kLaneWidth / 2>(sum, std::make_integer_sequence<int, kLaneWidth>());
  return sum[0];
}

}  // namespace

void multiply(const Eigen::MatrixXd& A, const double* x, double* y) { multiply(false, A, x, y); }

void multiply_add(const Eigen::MatrixXd& A, const double* x, double* y) { multiply(true, A, x, y); }

void multiply_transposed(const Eigen::MatrixXd& A, const double* x, double* y) {
  const int rows = static_cast<int>(A.rows()), cols = static_cast<int>(A.cols());
  int col = 0;
  for (; col + kLaneWidth <= cols; col += kLaneWidth)
    store_lane(y + col, multiply_columns<true>(A.data() + col * rows, rows, kLaneWidth, x));
  if (const int left = cols - col; left > 0)
    store_part(y + col, multiply_columns<false>(A.data() + col * rows, rows, left, x), left);
}

}  // namespace conddp
