#include "solvers/constraints/row_lanes.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace conddp::testing {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(RowLanes, EveryRowIsVisitedOnceInOrder) {
  for (int rows = 0; rows <= 3 * kLaneWidth; ++rows) {
    std::vector<int> seen;
    for_each_lane(rows, [&](auto kind, int first) {
      for (std::size_t i = 0; i < sizeof(kind) / sizeof(double); ++i)
        seen.push_back(first + static_cast<int>(i));
    });
    ASSERT_EQ(static_cast<int>(seen.size()), rows);
    for (int r = 0; r < rows; ++r) EXPECT_EQ(seen[r], r);
  }
}

TEST(RowLanes, BoundaryAndNaNRowsAreNotInside) {
  for (int rows = 1; rows <= 2 * kLaneWidth + 1; ++rows) {
    std::vector<double> values(rows, 0.5);
    const std::vector<double> lower(rows, -kInfinity), upper(rows, 1.0);
    const auto inside = [&] {
      return all_strictly_inside(values.data(), lower.data(), upper.data(), rows);
    };
    EXPECT_TRUE(inside());
    for (int r = 0; r < rows; ++r) {
      for (const double off : {1.0, 2.0, -kInfinity, std::numeric_limits<double>::quiet_NaN()}) {
        values[r] = off;
        EXPECT_FALSE(inside()) << "row " << r << " of " << rows << " at " << off;
      }
      values[r] = 0.5;
    }
  }
}

}  // namespace
}  // namespace conddp::testing
