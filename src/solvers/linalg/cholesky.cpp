#include "solvers/linalg/cholesky.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "solvers/linalg/lane_gemm.hpp"
#include "spatial/lane_memory.hpp"

namespace conddp {
namespace {

/// The part of a factor that a tile uses.
struct FactorPart {
  const double* L;
  int stride;
  int first;                 ///< column of L where the tile begins
  int n;                     ///< size of L
  const double* reciprocal;  ///< reciprocals of L's diagonal, from that column on
};

/// A tile of right-hand sides (columns of B) that stays in registers.
template <int kLanes, int kCols>
struct TileSums {
  Lane at[kCols][kLanes];

  TileSums(const double* B, int stride) {
#pragma GCC unroll 8
    for (int c = 0; c < kCols; ++c)
#pragma GCC unroll 8
      for (int r = 0; r < kLanes; ++r) at[c][r] = load_lane(B + c * stride + r * kLaneWidth);
  }
  void subtract(int c, const Lane* x, double factor) {
#pragma GCC unroll 8
    for (int r = 0; r < kLanes; ++r) at[c][r] -= x[r] * Lane(factor);
  }
  void scale(int c, double factor) {
#pragma GCC unroll 8
    for (int r = 0; r < kLanes; ++r) at[c][r] *= Lane(factor);
  }
  void store(double* B, int stride) const {
#pragma GCC unroll 8
    for (int c = 0; c < kCols; ++c)
#pragma GCC unroll 8
      for (int r = 0; r < kLanes; ++r) store_lane(B + c * stride + r * kLaneWidth, at[c][r]);
  }
};

/// Solves for some columns of Y in Y Lᵀ = B from the columns before them. `B` points to the first
/// one.
template <int kLanes, int kCols>
void forward_tile(const FactorPart& part, double* B, int stride) {
  TileSums<kLanes, kCols> sum(B, stride);
  const double* x = B - part.first * stride;
  for (int k = 0; k < part.first; ++k, x += stride) {
    Lane known[kLanes];
#pragma GCC unroll 8
    for (int r = 0; r < kLanes; ++r) known[r] = load_lane(x + r * kLaneWidth);
    const double* row = part.L + k * part.stride + part.first;
#pragma GCC unroll 8
    for (int c = 0; c < kCols; ++c) sum.subtract(c, known, row[c]);
  }
  const double* diagonal = part.L + part.first * part.stride + part.first;
#pragma GCC unroll 8
  for (int c = 0; c < kCols; ++c) {
    sum.scale(c, part.reciprocal[c]);
#pragma GCC unroll 8
    for (int i = c + 1; i < kCols; ++i) sum.subtract(i, sum.at[c], diagonal[c * part.stride + i]);
  }
  sum.store(B, stride);
}

/// Solves for some columns of X in X L = Y from the columns after them.
template <int kLanes, int kCols>
void backward_tile(const FactorPart& part, double* B, int stride) {
  TileSums<kLanes, kCols> sum(B, stride);
  const double* column = part.L + part.first * part.stride;
  const double* x = B + kCols * stride;
  for (int k = part.first + kCols; k < part.n; ++k, x += stride) {
    Lane known[kLanes];
#pragma GCC unroll 8
    for (int r = 0; r < kLanes; ++r) known[r] = load_lane(x + r * kLaneWidth);
#pragma GCC unroll 8
    for (int c = 0; c < kCols; ++c) sum.subtract(c, known, column[c * part.stride + k]);
  }
#pragma GCC unroll 8
  for (int c = kCols - 1; c >= 0; --c) {
    sum.scale(c, part.reciprocal[c]);
#pragma GCC unroll 8
    for (int i = 0; i < c; ++i)
      sum.subtract(i, sum.at[c], column[i * part.stride + part.first + c]);
  }
  sum.store(B, stride);
}

using Tile = void (*)(const FactorPart&, double*, int);
using Tiles = std::array<std::array<Tile, kTileCols>, kTileLanes>;

template <int kLanes, int... kCols>
constexpr std::array<Tile, kTileCols> forward_tiles(std::integer_sequence<int, kCols...>) {
  return {forward_tile<kLanes, kCols + 1>...};
}
template <int kLanes, int... kCols>
constexpr std::array<Tile, kTileCols> backward_tiles(std::integer_sequence<int, kCols...>) {
  return {backward_tile<kLanes, kCols + 1>...};
}
template <int... kLanes>
constexpr Tiles all_tiles(bool forward, std::integer_sequence<int, kLanes...>) {
  constexpr auto cols = std::make_integer_sequence<int, kTileCols>();
  if (forward) return {forward_tiles<kLanes + 1>(cols)...};
  return {backward_tiles<kLanes + 1>(cols)...};
}

/// Indexed by lanes − 1 and columns − 1.
constexpr Tiles kForward = all_tiles(true, std::make_integer_sequence<int, kTileLanes>());
constexpr Tiles kBackward = all_tiles(false, std::make_integer_sequence<int, kTileLanes>());

}  // namespace

bool cholesky_in_place(const LaneBlock& A) {
  const int n = A.cols, stride = A.stride;
  double* const data = A.data;
  for (int j = 0; j < n; ++j) {
    double* column = data + j * stride;
    double subtracted = 0;
    for (int i = 0; i < j; ++i) subtracted += data[i * stride + j] * data[i * stride + j];
    const double pivot = column[j];
    // A pivot left by cancellation is noise, and so are the gains that follow from it.
    const double rounding = 4 * std::numeric_limits<double>::epsilon() * subtracted;
    if (!(pivot > rounding) || !std::isfinite(pivot)) return false;
    // The other columns wait for a division only, not for the root.
    const double inverse = 1 / pivot;
    const int first = j / kLaneWidth * kLaneWidth;
    for (int row = first; row < n; row += kLaneWidth) {
      const Lane x = load_lane(column + row);
      for (int i = j + 1; i < std::min(n, row + kLaneWidth); ++i) {
        double* other = data + i * stride + row;
        store_lane(other, load_lane(other) - x * Lane(column[i] * inverse));
      }
    }
    const double root = std::sqrt(pivot);
    const Lane reciprocal(1 / root);
    for (int row = first; row < n; row += kLaneWidth)
      store_lane(column + row, load_lane(column + row) * reciprocal);
    column[j] = root;
  }
  return true;
}

void solve_rows_in_place(const LaneBlock& L, const LaneBlock& B) {
  const int n = L.cols;
  const int lanes = (B.rows + kLaneWidth - 1) / kLaneWidth;
  const auto columns = [&](const Tiles& tiles, int first, int count) {
    double reciprocal[kTileCols];
    for (int c = 0; c < count; ++c) reciprocal[c] = 1 / L.data[(first + c) * (L.stride + 1)];
    const FactorPart part{L.data, L.stride, first, n, reciprocal};
    for (int lane = 0; lane < lanes;) {
      const int left = lanes - lane;
      const int width =
          left > kTileLanes && left < 2 * kTileLanes ? (left + 1) / 2 : std::min(left, kTileLanes);
      tiles[width - 1][count - 1](part, B.data + first * B.stride + lane * kLaneWidth, B.stride);
      lane += width;
    }
  };
  const int tile_cols = even_tile_cols(lanes, n);
  for (int first = 0; first < n; first += tile_cols)
    columns(kForward, first, std::min(tile_cols, n - first));
  for (int first = (n - 1) / tile_cols * tile_cols; first >= 0; first -= tile_cols)
    columns(kBackward, first, std::min(tile_cols, n - first));
}

}  // namespace conddp
