#include "ocp/evaluation/lane_transfer.hpp"

#include <algorithm>

namespace conddp {

void scatter_lanes(const Lane* from, int n, double* const* to, int knots) {
  with_lanes_of(knots, [&](auto lanes) {
    constexpr int kLanes = decltype(lanes)::value;
    Lane x[kLaneWidth];
    int i = 0;
    for (; i + kLaneWidth <= n; i += kLaneWidth) {
#pragma GCC unroll 8
      for (int j = 0; j < kLaneWidth; ++j) x[j] = from[i + j];
      transpose_lanes<kLanes>(x);
      for (int l = 0; l < knots; ++l) store_lane(to[l] + i, x[l]);
    }
    const int left = n - i;
    if (left == 0) return;
#pragma GCC unroll 8
    for (int j = 0; j < kLaneWidth; ++j) x[j] = j < left ? from[i + j] : Lane(0.0);
    transpose_lanes<kLanes>(x);
    for (int l = 0; l < knots; ++l) store_part(to[l] + i, x[l], left);
  });
}

LaneScatter LaneScatter::matrix(const std::vector<std::pair<int, int>>& entries, int rows,
                                int columns) {
  std::vector<int> entry_at(rows * columns, -1);
  for (std::size_t e = 0; e < entries.size(); ++e)
    entry_at[entries[e].second * rows + entries[e].first] = static_cast<int>(e);
  return LaneScatter(entry_at);
}

LaneScatter LaneScatter::symmetric(const std::vector<std::pair<int, int>>& entries, int n) {
  std::vector<int> entry_at(n * n, -1);
  for (std::size_t e = 0; e < entries.size(); ++e) {
    const auto [row, column] = entries[e];
    entry_at[column * n + row] = entry_at[row * n + column] = static_cast<int>(e);
  }
  return LaneScatter(entry_at);
}

LaneScatter::LaneScatter(const std::vector<int>& entry_at)
    : run_length_(std::min(kLaneWidth, static_cast<int>(entry_at.size()))) {
  const int size = static_cast<int>(entry_at.size());
  for (int at = 0; at < size; ++at) {
    if (entry_at[at] < 0) continue;
    Run& run = runs_.emplace_back();
    // Starts at a lane boundary if possible: a store across cache lines takes two accesses.
    run.at = std::min(at / kLaneWidth * kLaneWidth, size - run_length_);
    run.entries.fill(-1);
    std::copy_n(&entry_at[run.at], run_length_, run.entries.begin());
    at = run.at + run_length_ - 1;
  }
}

void LaneScatter::operator()(const Lane* entries, double* const* to, int knots) const {
  with_lanes_of(knots, [&](auto lanes) {
    constexpr int kLanes = decltype(lanes)::value;
    const Lane zero(0.0);
    Lane x[kLaneWidth];
    for (const Run& run : runs_) {
#pragma GCC unroll 8
      for (int j = 0; j < kLaneWidth; ++j)
        x[j] = *(run.entries[j] < 0 ? &zero : entries + run.entries[j]);
      transpose_lanes<kLanes>(x);
      if (run_length_ == kLaneWidth) {
        for (int l = 0; l < knots; ++l) store_lane(to[l] + run.at, x[l]);
      } else {
        for (int l = 0; l < knots; ++l) store_part(to[l] + run.at, x[l], run_length_);
      }
    }
  });
}

}  // namespace conddp
