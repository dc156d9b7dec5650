#include "base/exceeds.hpp"

#include <limits>
#include <vector>

#include <gtest/gtest.h>

namespace conddp {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

TEST(Exceeds, ByMoreThanTheMargin) {
  EXPECT_TRUE(exceeds(2.01, 2));
  EXPECT_FALSE(exceeds(2.001, 2));
  EXPECT_FALSE(exceeds(2, 2));
  EXPECT_FALSE(exceeds(1.9, 2));
  EXPECT_TRUE(exceeds(-1.99, -2));
  EXPECT_FALSE(exceeds(-1.999, -2));
  EXPECT_TRUE(exceeds(1e-300, 0));
}

TEST(Exceeds, NumbersThatAreNotFinite) {
  EXPECT_TRUE(exceeds(kInfinity, 2));
  EXPECT_TRUE(exceeds(2, -kInfinity));
  EXPECT_FALSE(exceeds(kInfinity, kInfinity));
  EXPECT_FALSE(exceeds(kNaN, 2));
}

TEST(WorstOf, TheFirstOfNearlyEqualValuesStays) {
  EXPECT_EQ(worst_of(std::vector{3.0, 3.0 + 1e-9}), 0);
  EXPECT_EQ(worst_of(std::vector{3.0 + 1e-9, 3.0}), 0);
  EXPECT_EQ(worst_of(std::vector{1.0, 3.0, 3.001, 2.0}), 1);
  // The lag behind the maximum never exceeds the margin, however slowly values rise.
  std::vector<double> slope(1, 1.0);
  while (slope.size() < 10000) slope.push_back(slope.back() * 1.0005);
  EXPECT_GE(slope[worst_of(slope)], slope.back() / 1.0011);
}

TEST(SortWorstFirst, NearlyEqualValuesKeepTheirOrder) {
  std::vector<double> values{1, 4, 3 - 1e-9, 3, 4 + 1e-9, 5};
  sort_worst_first(values.begin(), values.end(), [](double value) { return value; });
  EXPECT_EQ(values, (std::vector<double>{5, 4, 4 + 1e-9, 3 - 1e-9, 3, 1}));
}

}  // namespace
}  // namespace conddp
