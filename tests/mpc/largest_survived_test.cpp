#include <vector>

#include <gtest/gtest.h>

#include "mpc/closed_loop.hpp"

namespace conddp {
namespace {

TEST(LargestSurvived, IsWithinTheWidthOfTheThreshold) {
  std::vector<double> tried;
  const auto largest = largest_survived(0, 8, 0.125, [&](double value) {
    tried.push_back(value);
    return value < 2.7;
  });
  EXPECT_EQ(largest, 2.625);
  EXPECT_EQ(tried, (std::vector<double>{0, 8, 4, 2, 3, 2.5, 2.75, 2.625}));
}

TEST(LargestSurvived, IsTheUpperEndIfAllSurvive) {
  EXPECT_EQ(largest_survived(1, 2, 0.1, [](double) { return true; }), 2);
}

TEST(LargestSurvived, DoesNotExistIfTheLowerEndFails) {
  int trials = 0;
  EXPECT_FALSE(largest_survived(1, 2, 0.1, [&](double) { return ++trials < 0; }));
  EXPECT_EQ(trials, 1);
}

TEST(LargestSurvived, EndsAtAdjacentNumbers) {
  EXPECT_EQ(largest_survived(1, 1.5, 0, [](double value) { return value <= 1; }), 1);
}

}  // namespace
}  // namespace conddp
