#pragma once

#include "spatial/lane.hpp"

namespace conddp {

/// The size of tiles of the sweep's matrices: a tile's numbers, a column of the left factor and one
/// number of the right one fit the registers, of which there are 32 with AVX-512 and 16 without.
constexpr int kTileLanes = kLaneWidth == 8 ? 4 : 2;
constexpr int kTileCols = kLaneWidth == 8 ? 7 : 6;

/// How many columns of n each tile of a matrix of so many lanes takes: tiles as even as can be,
/// since a thin one waits for its sums.
constexpr int even_tile_cols(int lanes, int n) {
  const int most = lanes < kTileLanes ? kTileCols : 6;
  const int tiles = n > most ? (n + most - 1) / most : 1;
  return n > 0 ? (n + tiles - 1) / tiles : 1;
}

}  // namespace conddp
