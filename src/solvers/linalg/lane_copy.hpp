#pragma once

#include <algorithm>
#include <utility>

#include "solvers/linalg/lane_matrix.hpp"
#include "spatial/lane_memory.hpp"

namespace conddp {

/// to (cols x rows) ← fromᵀ, column-major with these strides.
void transpose(const double* from, int from_stride, int rows, int cols, double* to, int to_stride);
/// Mirrors the lower triangle of a square matrix into the upper one, in its columns from
/// `first_col` on (and possibly in some before it).
void mirror_lower(const LaneBlock& A, int first_col = 0);
/// `to` (square, column-major) ← the symmetric matrix with lower triangle `A`. True if all entries
/// are finite.
bool copy_symmetric(const LaneBlock& A, double* to, int to_stride);

/// kLaneWidth columns of one lane each, in registers.
using LaneSquare = Lane[kLaneWidth];

inline void load_columns(LaneSquare& x, const double* from, int stride) {
#pragma GCC unroll 8
  for (int c = 0; c < kLaneWidth; ++c) x[c] = load_lane(from + c * stride);
}

/// Loads some rows and columns; the rest is zero.
inline void load_columns(LaneSquare& x, const double* from, int stride, int rows, int cols) {
  const auto load = [&](auto load_column) {
#pragma GCC unroll 8
    for (int c = 0; c < kLaneWidth; ++c)
      x[c] = c < cols ? load_column(from + c * stride) : Lane(0.0);
  };
  // One branch and one mask serve all columns.
  if (rows >= kLaneWidth)
    load(load_lane);
  else
    load([rows](const double* column) { return load_part(column, rows); });
}

inline void store_columns(const LaneSquare& x, double* to, int stride) {
#pragma GCC unroll 8
  for (int c = 0; c < kLaneWidth; ++c) store_lane(to + c * stride, x[c]);
}

inline void store_columns(const LaneSquare& x, double* to, int stride, int rows, int cols) {
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

template <int... kIndex>
inline void mirror_square(LaneSquare& x, std::integer_sequence<int, kIndex...>) {
  Lane transposed[kLaneWidth];
  std::copy(x, x + kLaneWidth, transposed);
  transpose_lanes(transposed);
  const LaneMask::Vector row{kIndex...};
#pragma GCC unroll 8
  for (int c = 1; c < kLaneWidth; ++c)
    x[c] = select(LaneMask{row < static_cast<std::int64_t>(c)}, transposed[c], x[c]);
}

/// Copies the lower triangle into the upper one.
inline void mirror_square(LaneSquare& x) {
  mirror_square(x, std::make_integer_sequence<int, kLaneWidth>());
}

/// Sum of the columns; not finite if a number is not finite.
inline Lane sum_of_columns(const LaneSquare& x) {
  Lane sum = x[0];
#pragma GCC unroll 8
  for (int c = 1; c < kLaneWidth; ++c) sum += x[c];
  return sum;
}

}  // namespace conddp
