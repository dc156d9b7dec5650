#pragma once

#include <array>
#include <utility>
#include <vector>

#include "spatial/lane_transpose.hpp"

namespace conddp {

/// Between numbers of a knot that stand side by side and lanes, one knot in each: in squares of
/// kLaneWidth that are transposed in registers.

/// Calls put(i, lane) for i < n, where lane l holds from[l][i].
template <class F>
void gather_lanes(const double* const (&from)[kLaneWidth], int n, F put) {
  int i = 0;
  Lane x[kLaneWidth];
  for (; i + kLaneWidth <= n; i += kLaneWidth) {
#pragma GCC unroll 8
    for (int l = 0; l < kLaneWidth; ++l) x[l] = load_lane(from[l] + i);
    transpose_lanes(x);
#pragma GCC unroll 8
    for (int j = 0; j < kLaneWidth; ++j) put(i + j, x[j]);
  }
  for (; i < n; ++i) {
    Lane single;
    for (int l = 0; l < kLaneWidth; ++l) single.set(l, from[l][i]);
    put(i, single);
  }
}

/// to[l][i] = lane l of from[i] for i < n, in the first `knots` lanes.
void scatter_lanes(const Lane* from, int n, double* const* to, int knots);

/// Writes matrices of which lanes hold the entries that can be other than zero, one matrix a lane.
/// What is outside of these entries must be zero already.
class LaneScatter {
 public:
  /// Entries (row, column), each once, of a matrix by columns.
  static LaneScatter matrix(const std::vector<std::pair<int, int>>& entries, int rows, int columns);
  /// Entries (row, column) with row ≥ column, each once, of a symmetric n x n matrix.
  static LaneScatter symmetric(const std::vector<std::pair<int, int>>& entries, int n);

  /// to[l] is the matrix of lane l, in the first `knots` lanes.
  void operator()(const Lane* entries, double* const* to, int knots) const;

 private:
  /// By place in the matrix the entry that stands there, −1 for none.
  explicit LaneScatter(const std::vector<int>& entry_at);

  /// Numbers that stand side by side in the matrix, by their entries; −1 is a zero.
  struct Run {
    int at;
    std::array<int, kLaneWidth> entries;
  };
  std::vector<Run> runs_;
  int run_length_;
};

}  // namespace conddp
