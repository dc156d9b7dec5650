#include "ocp/evaluation/lane_transfer.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "spatial/aligned.hpp"

namespace conddp {
namespace {

double number(int lane, int i) { return 1000 * lane + i; }

TEST(LaneTransfer, GatheringTakesEveryNumberOfEveryKnot) {
  for (int n = 0; n <= 3 * kLaneWidth + 1; ++n)
    for (int count = 1; count <= kLaneWidth; ++count) {
      std::vector<std::vector<double>> knots(count, std::vector<double>(n));
      std::vector<const double*> from(count);
      for (int l = 0; l < count; ++l) {
        for (int i = 0; i < n; ++i) knots[l][i] = number(l, i);
        from[l] = knots[l].data();
      }
      int numbers = 0;
      gather_lanes(from.data(), count, n, [&](int i, Lane value) {
        EXPECT_EQ(i, numbers++);
        for (int l = 0; l < count; ++l) EXPECT_EQ(value[l], number(l, i)) << n << " " << count;
        for (int l = count; l < kLaneWidth; ++l) {
          // Values come from some knot of the group.
          EXPECT_EQ(std::fmod(value[l], 1000), i) << n << " " << count;
          EXPECT_LT(value[l], 1000 * count);
        }
      });
      EXPECT_EQ(numbers, n);
    }
}

TEST(LaneTransfer, ScatteringWritesOnlyItsKnots) {
  for (int n = 0; n <= 3 * kLaneWidth + 1; ++n)
    for (int knots = 1; knots <= kLaneWidth; ++knots) {
      AlignedVector<Lane> from(n);
      for (int i = 0; i < n; ++i)
        for (int l = 0; l < kLaneWidth; ++l) from[i].set(l, number(l, i));
      std::vector<std::vector<double>> out(kLaneWidth, std::vector<double>(n + 1, -1));
      double* to[kLaneWidth];
      for (int l = 0; l < kLaneWidth; ++l) to[l] = out[l].data();
      scatter_lanes(from.data(), n, to, knots);
      for (int l = 0; l < kLaneWidth; ++l)
        for (int i = 0; i <= n; ++i)
          EXPECT_EQ(out[l][i], l < knots && i < n ? number(l, i) : -1) << n << " " << knots;
    }
}

TEST(LaneTransfer, MatricesKeepTheirLayout) {
  const std::vector<std::pair<int, int>> entries = {{4, 3}, {0, 1}, {2, 3}, {1, 0}};
  const LaneScatter scatter = LaneScatter::matrix(entries, 5, 4);
  AlignedVector<Lane> lanes(entries.size());
  for (std::size_t e = 0; e < entries.size(); ++e)
    for (int l = 0; l < kLaneWidth; ++l) lanes[e].set(l, number(l, 1 + static_cast<int>(e)));
  std::vector<std::vector<double>> out(kLaneWidth, std::vector<double>(20, 0));
  double* to[kLaneWidth];
  for (int l = 0; l < kLaneWidth; ++l) to[l] = out[l].data();
  scatter(lanes.data(), to, kLaneWidth);
  for (int l = 0; l < kLaneWidth; ++l) {
    for (std::size_t e = 0; e < entries.size(); ++e) {
      double& entry = out[l][entries[e].second * 5 + entries[e].first];
      EXPECT_EQ(entry, number(l, 1 + static_cast<int>(e)));
      entry = 0;
    }
    EXPECT_EQ(out[l], std::vector<double>(20, 0));
  }
}

TEST(LaneTransfer, SymmetricMatricesArriveWhole) {
  for (int n : {1, 2, 3, 9, 17})
    for (int every : {1, 3, 7}) {
      // All such lower-triangle entries, in shuffled order.
      std::vector<std::pair<int, int>> pattern;
      for (int row = n - 1; row >= 0; --row)
        for (int column = 0; column <= row; ++column)
          if ((row * n + column) % every == 0) pattern.emplace_back(row, column);
      AlignedVector<Lane> entries(pattern.size());
      for (std::size_t e = 0; e < pattern.size(); ++e)
        for (int l = 0; l < kLaneWidth; ++l)
          entries[e].set(l, number(l, 1 + pattern[e].first * n + pattern[e].second));
      const LaneScatter scatter = LaneScatter::symmetric(pattern, n);
      for (int knots = 1; knots <= kLaneWidth; ++knots) {
        std::vector<std::vector<double>> out(kLaneWidth, std::vector<double>(n * n + 1, 0));
        double* to[kLaneWidth];
        for (int l = 0; l < kLaneWidth; ++l) to[l] = out[l].data();
        scatter(entries.data(), to, knots);
        for (int l = 0; l < kLaneWidth; ++l) {
          EXPECT_EQ(out[l].back(), 0);
          for (int a = 0; a < n; ++a)
            for (int b = 0; b < n; ++b) {
              const int row = std::max(a, b), column = std::min(a, b);
              const bool filled = l < knots && (row * n + column) % every == 0;
              EXPECT_EQ(out[l][a * n + b], filled ? number(l, 1 + row * n + column) : 0);
            }
        }
      }
    }
}

}  // namespace
}  // namespace conddp
