#pragma once

#include <array>
#include <type_traits>
#include <utility>
#include <vector>

#include "spatial/lane_memory.hpp"

namespace conddp {

/// Transfers numbers between contiguous storage per knot and lanes that hold one knot each: squares
/// of kLaneWidth are transposed in registers.

/// Calls act with the smallest power of two ≥ `knots`, as a constant: the number of lanes to move.
template <int kLanes = 1, class F>
void with_lanes_of(int knots, F act) {
  if constexpr (kLanes < kLaneWidth) {
    if (knots > kLanes) return with_lanes_of<2 * kLanes>(knots, act);
  }
  act(std::integral_constant<int, kLanes>());
}

/// Calls put(i, lane) for i < n, where lane l holds from[l][i] for l < knots. The remaining lanes
/// repeat the numbers of some of these knots.
template <class F>
void gather_lanes(const double* const* from, int knots, int n, F put) {
  with_lanes_of(knots, [&](auto lanes) {
    constexpr int kLanes = decltype(lanes)::value;
    const double* of_lane[kLanes];
    for (int l = 0; l < kLanes; ++l) of_lane[l] = from[l < knots ? l : knots - 1];
    const auto take = [&](int i, int count, auto load) {
      Lane x[kLaneWidth];
#pragma GCC unroll 8
      for (int l = 0; l < kLaneWidth; ++l) x[l] = l < kLanes ? load(of_lane[l] + i) : x[kLanes - 1];
      transpose_lanes(x);
#pragma GCC unroll 8
      for (int j = 0; j < kLaneWidth; ++j)
        if (j < count) put(i + j, x[j]);
    };
    int i = 0;
    for (; i + kLaneWidth <= n; i += kLaneWidth) take(i, kLaneWidth, load_lane);
    if (const int left = n - i; left > 0)
      take(i, left, [left](const double* at) { return load_part(at, left); });
  });
}

/// to[l][i] = lane l of from[i] for i < n, in the first `knots` lanes.
void scatter_lanes(const Lane* from, int n, double* const* to, int knots);

/// Writes one matrix per lane from lanes that hold its possibly nonzero entries. All other entries
/// must be zero already.
class LaneScatter {
 public:
  /// Entries (row, column), each once, of a matrix by columns.
  static LaneScatter matrix(const std::vector<std::pair<int, int>>& entries, int rows, int columns);
  /// Entries (row, column) with row ≥ column, each once, of a symmetric n x n matrix.
  static LaneScatter symmetric(const std::vector<std::pair<int, int>>& entries, int n);

  /// to[l] is the matrix of lane l, in the first `knots` lanes.
  void operator()(const Lane* entries, double* const* to, int knots) const;

 private:
  /// `entry_at`: the entry at each place of the matrix, −1 for none.
  explicit LaneScatter(const std::vector<int>& entry_at);

  /// Contiguous numbers of the matrix, by their entries; −1 is a zero.
  struct Run {
    int at;
    std::array<int, kLaneWidth> entries;
  };
  std::vector<Run> runs_;
  int run_length_;
};

}  // namespace conddp
