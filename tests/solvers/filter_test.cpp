#include "solvers/interior/filter.hpp"

#include <limits>

#include <gtest/gtest.h>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Filter, TakesWhatImprovesOneOfBoth) {
  Filter filter(10);
  filter.start(1);
  EXPECT_TRUE(filter.accepts(1, 1, {1, 5}, {0.5, 9}));
  EXPECT_TRUE(filter.accepts(1, 1, {1, 5}, {1, 4}));
  EXPECT_FALSE(filter.accepts(1, 1, {1, 5}, {1, 5}));
  EXPECT_FALSE(filter.accepts(1, 1, {1, 5}, {2, 6}));
}

TEST(Filter, RemembersPointsThatItLeft) {
  Filter filter(10);
  filter.start(1);
  ASSERT_TRUE(filter.accepts(1, 1, {1, 5}, {0.5, 9}));
  EXPECT_FALSE(filter.accepts(1, 1, {0.5, 9}, {1, 5.5})) << "worse than the first point in both";
  filter.clear();
  EXPECT_TRUE(filter.accepts(1, 1, {0.5, 9}, {1, 5.5}));
}

TEST(Filter, AsksForDescentWhereConstraintsHold) {
  Filter filter(10);
  filter.start(1);
  EXPECT_TRUE(filter.accepts(1, -1, {0, 5}, {0, 4.5}));
  EXPECT_FALSE(filter.accepts(1, -1, {0, 5}, {0, 5 - 1e-5})) << "less than Armijo's rule asks for";
  EXPECT_TRUE(filter.accepts(1e-2, -1, {0, 5}, {0, 5 - 1e-5})) << "a shorter step";
}

TEST(Filter, ForgetsWithoutMoreInfeasibility) {
  Filter filter(10);
  filter.start(1);
  EXPECT_FALSE(filter.forget(1)) << "nothing to forget";
  ASSERT_TRUE(filter.accepts(1, 1, {1, 5}, {0.5, 9}));
  ASSERT_FALSE(filter.accepts(1, 1, {2, 9}, {1, 5.5}));
  EXPECT_TRUE(filter.forget(2));
  EXPECT_FALSE(filter.accepts(1, 1, {2, 9}, {2.1, 1})) << "more infeasible than where it forgot";
  EXPECT_TRUE(filter.accepts(1, 1, {2, 9}, {1, 5.5}));
  filter.clear();
  EXPECT_TRUE(filter.accepts(1, 1, {2, 9}, {2.1, 1})) << "the next barrier problem";
}

TEST(Filter, ForgetsAFewTimes) {
  Filter filter(10);
  filter.start(1);
  int times = 0;
  while (filter.accepts(1, 1, {1, 5}, {0.5, 9}) && filter.forget(1)) ++times;
  EXPECT_EQ(times, tuning::interior::kForgotten);
}

TEST(Filter, RefusesValuesThatAreNotFinite) {
  Filter filter(10);
  filter.start(1);
  EXPECT_FALSE(filter.accepts(1, -1, {1, 5}, {kNan, 0}));
  EXPECT_FALSE(filter.accepts(1, -1, {1, 5}, {0, kNan}));
  EXPECT_FALSE(filter.accepts(1, -1, {1, 5}, {1e5, 0})) << "beyond the largest infeasibility";
}

}  // namespace
}  // namespace conddp
