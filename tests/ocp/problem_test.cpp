#include "ocp/problem/problem.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

std::vector<double> steps(int count, double step) { return std::vector<double>(count, step); }

TEST(NodeTimes, AreTheDecimalNumbersThatPeopleExpect) {
  EXPECT_EQ(node_times(steps(50, 0.06)).back(), 3.0);
  EXPECT_EQ(node_times(steps(3, 0.1)).back(), 0.3);
  EXPECT_EQ(node_times(steps(1'000'000, 0.001)).back(), 1000.0);
  const std::vector<double> times = node_times(steps(500, 0.02));
  ASSERT_EQ(times.size(), 501u);
  EXPECT_EQ(times[0], 0);
  for (int k = 0; k <= 500; ++k) EXPECT_EQ(times[k], std::stod(std::to_string(2 * k) + "e-2")) << k;
}

TEST(NodeTimes, AddUpDifferentSteps) {
  std::vector<double> mixed = steps(30, 0.01);
  mixed.insert(mixed.end(), 7, 0.3);
  mixed.insert(mixed.end(), 3, 1.0 / 3);
  EXPECT_EQ(node_times(mixed)[37], 2.4);
  EXPECT_NEAR(node_times(mixed).back(), 3.4, 1e-15);
  EXPECT_EQ(node_times({}), std::vector<double>{0});
}

}  // namespace
}  // namespace conddp
