#include "solvers/common/settled_cost.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace conddp {
namespace {

std::vector<IterationRecord> log_of(const std::vector<double>& costs, double step = 1) {
  std::vector<IterationRecord> log;
  for (const double cost : costs) {
    log.emplace_back();
    log.back().cost = cost;
    log.back().step = log.size() == 1 ? 0 : step;
  }
  return log;
}

TEST(SettledCost, NeedsThreeStepsInARow) {
  EXPECT_TRUE(cost_has_settled(log_of({100, 99.9, 99.8, 99.7}), 0.01));
  EXPECT_FALSE(cost_has_settled(log_of({99.9, 99.8, 99.7}), 0.01)) << "two steps";
  EXPECT_TRUE(cost_has_settled(log_of({500, 100, 99.9, 99.8, 99.7}), 0.01));
  EXPECT_FALSE(cost_has_settled(log_of({100, 99.9, 90, 89.9}), 0.01)) << "the second fell far";
  EXPECT_FALSE(cost_has_settled(log_of({102, 100, 99.9, 99.8}), 0.01)) << "so did the first";
}

TEST(SettledCost, FallEqualToTheShareHasSettled) {
  EXPECT_TRUE(cost_has_settled(log_of({5, 4, 4, 4}), 0.25));
  EXPECT_FALSE(cost_has_settled(log_of({5.001, 4, 4, 4}), 0.25));
}

TEST(SettledCost, RisesCountLikeFalls) {
  EXPECT_TRUE(cost_has_settled(log_of({-100, -99.9, -100, -99.9}), 0.01));
  EXPECT_FALSE(cost_has_settled(log_of({-100, -99.9, -100, -90}), 0.01));
}

TEST(SettledCost, ShortStepsAreMeasuredAtTheirRate) {
  const std::vector<double> costs = {100, 99.9, 99.8, 99.7};
  EXPECT_TRUE(cost_has_settled(log_of(costs, 0.2), 0.01));
  EXPECT_FALSE(cost_has_settled(log_of(costs, 0.05), 0.01));
  EXPECT_FALSE(cost_has_settled(log_of({100, 100, 100, 99.999}, 1e-6), 0.01));
}

TEST(SettledCost, IsOffAtZeroAndWithoutCosts) {
  EXPECT_FALSE(cost_has_settled(log_of({1, 1, 1, 1}), 0));
  EXPECT_FALSE(cost_has_settled({}, 0.5));
  const double none = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(cost_has_settled(log_of({1, 1, 1, none}), 0.5));
}

}  // namespace
}  // namespace conddp
