#pragma once

#include "solvers/linalg/lane_matrix.hpp"
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

/// Products of the small dense matrices of a sweep. Tiles of the result stay in registers along the
/// inner dimension. Sums run over it in order for any lane width.

/// The right factor of a product. Entry (k, j) is data[k · row_step + j · column_step], so that a
/// transposed matrix is not copied.
struct Factor {
  const double* data;
  int row_step, column_step;

  static Factor of(const LaneMatrix& B) { return {B.data(), 1, B.stride()}; }
  static Factor transposed(const LaneMatrix& B) { return {B.data(), B.stride(), 1}; }
  template <class Matrix>
  static Factor of_eigen(const Matrix& B) {
    return {B.data(), 1, static_cast<int>(B.outerStride())};
  }
};

enum class Store { set, add, subtract };

/// C ←, += or −= A B. C must not overlap A or B.
void multiply(Store store, const LaneBlock& C, const LaneBlock& A, Factor B);
/// The lower triangle of the same product; entries above the diagonal become undefined.
void multiply_lower(Store store, const LaneBlock& C, const LaneBlock& A, Factor B);

}  // namespace conddp
