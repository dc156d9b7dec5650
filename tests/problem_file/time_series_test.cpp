#include "problem_file/time_series.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(TimeSeries, InterpolatesAndHoldsFlatValues) {
  TimeSeries series(StateManifold::flat(1));
  series.append(1, {10});
  series.append(2, {20});
  EXPECT_EQ(series.interpolate(0)[0], 10);
  EXPECT_NEAR(series.interpolate(1.25)[0], 12.5, 1e-12);
  EXPECT_EQ(series.interpolate(3)[0], 20);
  EXPECT_EQ(series.hold(0)[0], 10);
  EXPECT_EQ(series.hold(1.999)[0], 10);
  EXPECT_EQ(series.hold(2 - 1e-12)[0], 20);  // rounding of accumulated times
}

TEST(TimeSeries, RotationsFollowTheShortestWay) {
  TimeSeries series(rotation_manifold());
  const double half = 0.75;  // half of 1.5 rad about z
  series.append(0, {0, 0, 0, 1});
  series.append(1, {0, 0, -std::sin(half), -std::cos(half)});  // the same rotation, other sign
  const std::vector<double> q = series.interpolate(0.5);
  EXPECT_NEAR(std::abs(q[2]), std::sin(half / 2), 1e-12);
  EXPECT_NEAR(std::abs(q[3]), std::cos(half / 2), 1e-12);
}

TEST(TimeSeries, PosesMoveStraightWhileTheyTurn) {
  TimeSeries series(pose_manifold());
  series.append(0, {0, 0, 0, 0, 0, 0, 1});
  series.append(1, {2, 4, 6, 0, 0, 1, 0});
  const std::vector<double> pose = series.interpolate(0.5);
  EXPECT_NEAR(pose[0], 1, 1e-12);
  EXPECT_NEAR(pose[2], 3, 1e-12);
}

}  // namespace
}  // namespace conddp
