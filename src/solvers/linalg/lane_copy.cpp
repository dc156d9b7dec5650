#include "solvers/linalg/lane_copy.hpp"

#include <algorithm>
#include <utility>

#include "spatial/lane_part.hpp"

namespace conddp {
namespace {

inline void load_columns(Lane (&x)[kLaneWidth], const double* from, int stride) {
#pragma GCC unroll 8
  for (int c = 0; c < kLaneWidth; ++c) x[c] = load_lane(from + c * stride);
}

inline void load_columns(Lane (&x)[kLaneWidth], const double* from, int stride, int rows,
                         int cols) {
  const auto load = [&](auto load_column) {
#pragma GCC unroll 8
    for (int c = 0; c < kLaneWidth; ++c)
      x[c] = c < cols ? load_column(from + c * stride) : Lane(0.0);
  };
  // One choice and one mask for all columns.
  if (rows >= kLaneWidth)
    load(load_lane);
  else
    load([rows](const double* column) { return load_part(column, rows); });
}

inline void store_columns(const Lane (&x)[kLaneWidth], double* to, int stride) {
#pragma GCC unroll 8
  for (int c = 0; c < kLaneWidth; ++c) store_lane(to + c * stride, x[c]);
}

inline void store_columns(const Lane (&x)[kLaneWidth], double* to, int stride, int rows, int cols) {
  const auto store = [&](auto store_column) {
#pragma GCC unroll 8
    for (int c = 0; c < kLaneWidth; ++c)
      if (c < cols) store_column(to + c * stride, x[c]);
  };
  if (rows >= kLaneWidth)
    store(store_lane);
  else
    store([rows](double* column, Lane values) { store_part(column, values, rows); });
}

/// Mirrors a square of the diagonal in registers.
template <int... kIndex>
inline void mirror_square(Lane (&x)[kLaneWidth], std::integer_sequence<int, kIndex...>) {
  Lane transposed[kLaneWidth];
  std::copy(x, x + kLaneWidth, transposed);
  transpose_lanes(transposed);
  const LaneMask::Vector row{kIndex...};
#pragma GCC unroll 8
  for (int c = 1; c < kLaneWidth; ++c)
    x[c] = select(LaneMask{row < static_cast<std::int64_t>(c)}, transposed[c], x[c]);
}

inline void mirror_square(Lane (&x)[kLaneWidth]) {
  mirror_square(x, std::make_integer_sequence<int, kLaneWidth>());
}

}  // namespace

void transpose(const double* from, int from_stride, int rows, int cols, double* to, int to_stride) {
  Lane x[kLaneWidth];
  for (int col = 0; col < cols; col += kLaneWidth)
    for (int row = 0; row < rows; row += kLaneWidth) {
      const int rows_left = rows - row, cols_left = cols - col;
      const double* source = from + col * from_stride + row;
      double* target = to + row * to_stride + col;
      if (rows_left >= kLaneWidth && cols_left >= kLaneWidth) {
        load_columns(x, source, from_stride);
        transpose_lanes(x);
        store_columns(x, target, to_stride);
      } else {
        load_columns(x, source, from_stride, rows_left, cols_left);
        transpose_lanes(x);
        store_columns(x, target, to_stride, cols_left, rows_left);
      }
    }
}

void mirror_lower(const LaneBlock& A, int first_col) {
  Lane x[kLaneWidth];
  const int first = first_col / kLaneWidth * kLaneWidth;
  for (int col = 0; col < A.cols; col += kLaneWidth) {
    const int cols = A.cols - col;
    double* square = A.data + col * A.stride + col;
    if (col >= first) {
      load_columns(x, square, A.stride, kLaneWidth, cols);
      mirror_square(x);
      store_columns(x, square, A.stride, kLaneWidth, cols);
    }
    for (int row = std::max(first, col + kLaneWidth); row < A.rows; row += kLaneWidth) {
      load_columns(x, A.data + col * A.stride + row, A.stride);
      transpose_lanes(x);
      store_columns(x, A.data + row * A.stride + col, A.stride, kLaneWidth, A.rows - row);
    }
  }
}

bool copy_symmetric(const LaneBlock& A, double* to, int to_stride) {
  Lane x[kLaneWidth];
  Lane finite(0.0);  // a sum of zeros, unless a number is not finite
  const auto check = [&] {
    // One square does not wait for the other: the sum of its columns comes first.
    Lane sum = x[0];
#pragma GCC unroll 8
    for (int c = 1; c < kLaneWidth; ++c) sum += x[c];
    finite += sum * Lane(0.0);
  };
  for (int col = 0; col < A.cols; col += kLaneWidth) {
    const int cols = A.cols - col;
    load_columns(x, A.data + col * A.stride + col, A.stride, cols, cols);
    mirror_square(x);
    check();
    store_columns(x, to + col * to_stride + col, to_stride, cols, cols);
    for (int row = col + kLaneWidth; row < A.rows; row += kLaneWidth) {
      const int rows = A.rows - row;
      if (rows >= kLaneWidth) {
        load_columns(x, A.data + col * A.stride + row, A.stride);
        check();
        store_columns(x, to + col * to_stride + row, to_stride);
        transpose_lanes(x);
        store_columns(x, to + row * to_stride + col, to_stride);
      } else {
        load_columns(x, A.data + col * A.stride + row, A.stride, rows, kLaneWidth);
        check();
        store_columns(x, to + col * to_stride + row, to_stride, rows, kLaneWidth);
        transpose_lanes(x);
        store_columns(x, to + row * to_stride + col, to_stride, kLaneWidth, rows);
      }
    }
  }
  double sum = 0;
  for (int l = 0; l < kLaneWidth; ++l) sum += finite[l];
  return sum == 0;
}

}  // namespace conddp
