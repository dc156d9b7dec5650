#include "solvers/linalg/lane_gemm.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "spatial/lane_memory.hpp"

namespace conddp {
namespace {

template <int kLanes, int kCols>
void tile(Store mode, int inner, const double* __restrict A, int a_stride, Factor B,
          double* __restrict C, int c_stride) {
  Lane sum[kCols][kLanes];
#pragma GCC unroll 8
  for (int c = 0; c < kCols; ++c)
#pragma GCC unroll 8
    for (int r = 0; r < kLanes; ++r) sum[c][r] = Lane(0.0);
  const double* b = B.data;
  for (int k = 0; k < inner; ++k) {
    Lane a[kLanes];
#pragma GCC unroll 8
    for (int r = 0; r < kLanes; ++r) a[r] = load_lane(A + r * kLaneWidth);
#pragma GCC unroll 8
    for (int c = 0; c < kCols; ++c) {
      const Lane factor(b[c * B.column_step]);
#pragma GCC unroll 8
      for (int r = 0; r < kLanes; ++r) sum[c][r] += a[r] * factor;
    }
    A += a_stride;
    b += B.row_step;
  }
#pragma GCC unroll 8
  for (int c = 0; c < kCols; ++c)
#pragma GCC unroll 8
    for (int r = 0; r < kLanes; ++r) {
      double* out = C + c * c_stride + r * kLaneWidth;
      if (mode == Store::add) sum[c][r] = load_lane(out) + sum[c][r];
      if (mode == Store::subtract) sum[c][r] = load_lane(out) - sum[c][r];
      store_lane(out, sum[c][r]);
    }
}

using Tile = void (*)(Store, int, const double*, int, Factor, double*, int);

template <int kLanes, int... kCols>
constexpr std::array<Tile, kTileCols> tiles_of(std::integer_sequence<int, kCols...>) {
  return {tile<kLanes, kCols + 1>...};
}

template <int... kLanes>
constexpr std::array<std::array<Tile, kTileCols>, kTileLanes> all_tiles(
    std::integer_sequence<int, kLanes...>) {
  return {tiles_of<kLanes + 1>(std::make_integer_sequence<int, kTileCols>())...};
}

/// Indexed by lanes − 1 and columns − 1.
constexpr auto kTiles = all_tiles(std::make_integer_sequence<int, kTileLanes>());

void multiply_tiles(Store mode, bool lower, const LaneBlock& C, const LaneBlock& A, Factor B) {
  const int lanes = (C.rows + kLaneWidth - 1) / kLaneWidth;
  const int tile_cols = even_tile_cols(lanes, C.cols);
  for (int col = 0; col < C.cols; col += tile_cols) {
    const int cols = std::min(tile_cols, C.cols - col);
    const Factor factor{B.data + col * B.column_step, B.row_step, B.column_step};
    for (int lane = lower ? col / kLaneWidth : 0; lane < lanes;) {
      const int left = lanes - lane;
      // Two even tiles instead of a full one and a thin one.
      const int count = left >= 2 * kTileLanes ? kTileLanes
                        : left > kTileLanes    ? (left + 1) / 2
                                               : left;
      const int row = lane * kLaneWidth;
      kTiles[count - 1][cols - 1](mode, A.cols, A.data + row, A.stride, factor,
                                  C.data + col * C.stride + row, C.stride);
      lane += count;
    }
  }
}

}  // namespace

void multiply(Store store, const LaneBlock& C, const LaneBlock& A, Factor B) {
  multiply_tiles(store, false, C, A, B);
}

void multiply_lower(Store store, const LaneBlock& C, const LaneBlock& A, Factor B) {
  multiply_tiles(store, true, C, A, B);
}

}  // namespace conddp
