#pragma once

#include "spatial/lane.hpp"

namespace conddp {

/// Tile size for the sweep's matrices. A tile, a column of the left factor and one number of the
/// right factor fit the registers: 32 with AVX-512, 16 without.
constexpr int kTileLanes = kLaneWidth == 8 ? 4 : 2;
constexpr int kTileCols = kLaneWidth == 8 ? 7 : 6;

/// Number of columns per tile of a matrix with n columns of so many lanes. Tiles are as even as
/// possible, since a thin one waits for its sums.
constexpr int even_tile_cols(int lanes, int n) {
  const int most = lanes < kTileLanes ? kTileCols : 6;
  const int tiles = n > most ? (n + most - 1) / most : 1;
  return n > 0 ? (n + tiles - 1) / tiles : 1;
}

}  // namespace conddp
