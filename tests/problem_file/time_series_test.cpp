#include "problem_file/data/time_series.hpp"

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

TEST(TimeSeries, JumpHasValuesBeforeAndAfter) {
  const double next = std::nextafter(2.0, 3.0);  // as in tables with increasing times
  for (const double again : {2.0, next}) {
    TimeSeries series(StateManifold::flat(1));
    series.append(1, {10});
    series.append(2, {20});
    series.append(again, {40});
    series.append(3, {50});
    for (const double time : {2.0, 2 - 1e-12, 2 + 1e-12}) {
      EXPECT_EQ(series.interpolate(time)[0], 40);
      EXPECT_EQ(series.interpolate(time, 1)[0], 20);
      EXPECT_EQ(series.interpolate(time, 2)[0], 20) << "the first one";
      EXPECT_EQ(series.hold(time)[0], 40);
    }
    EXPECT_NEAR(series.interpolate(1.5)[0], 15, 1e-12);
    EXPECT_NEAR(series.interpolate(2.5)[0], 45, 1e-12);
    EXPECT_EQ(series.interpolate(3, 1)[0], 50);
  }
}

TEST(TimeSeries, JumpsAtTimeZeroToo) {
  for (const double again : {0.0, std::nextafter(0.0, 1.0)}) {
    TimeSeries series(StateManifold::flat(1));
    series.append(0, {1});
    series.append(again, {2});
    series.append(1e-9, {4});
    EXPECT_EQ(series.interpolate(0, 1)[0], 1);
    EXPECT_EQ(series.interpolate(0)[0], 2);
    EXPECT_NEAR(series.interpolate(5e-10)[0], 3, 1e-9);
  }
}

TEST(TimeSeries, CubicSplineIsSmoothWithStraightEnds) {
  TimeSeries series(StateManifold::flat(1));
  const double times[] = {0, 1, 1.5, 3, 4}, values[] = {2, -1, 0, 5, 4};
  for (int i = 0; i < 5; ++i) series.append(times[i], {values[i]});
  series.make_cubic();
  const auto at = [&](double t) { return series.interpolate(t)[0]; };
  const double h = 1e-4;
  for (int i = 0; i < 5; ++i) EXPECT_NEAR(at(times[i]), values[i], 1e-12);
  const auto slope = [&](double t, double side) { return side * (at(t + side * h) - at(t)) / h; };
  const auto bend = [&](double t, double side) {
    return (at(t) - 2 * at(t + side * h) + at(t + 2 * side * h)) / (h * h);
  };
  for (int i = 1; i < 4; ++i) {
    EXPECT_NEAR(slope(times[i], 1), slope(times[i], -1), 1e-2);
    EXPECT_NEAR(bend(times[i], 1), bend(times[i], -1), 2e-2);
  }
  EXPECT_NEAR(bend(0, 1), 0, 1e-2);
  EXPECT_NEAR(bend(4, -1), 0, 1e-2);
  EXPECT_GT(std::abs(bend(1, 1)), 1);
}

TEST(TimeSeries, SplinesKeepStraightMotionsIncludingRotations) {
  TimeSeries series(rotation_manifold());
  for (int i = 0; i < 4; ++i) series.append(i, {0, 0, std::sin(0.2 * i), std::cos(0.2 * i)});
  series.make_cubic();
  const std::vector<double> q = series.interpolate(1.3);
  EXPECT_NEAR(q[2], std::sin(0.26), 1e-12);
  EXPECT_NEAR(q[3], std::cos(0.26), 1e-12);
}

TEST(TimeSeries, RotationsFollowTheShortestPath) {
  TimeSeries series(rotation_manifold());
  const double half = 0.75;  // half of 1.5 rad about z
  series.append(0, {0, 0, 0, 1});
  series.append(1, {0, 0, -std::sin(half), -std::cos(half)});  // same rotation, opposite sign
  const std::vector<double> q = series.interpolate(0.5);
  EXPECT_NEAR(std::abs(q[2]), std::sin(half / 2), 1e-12);
  EXPECT_NEAR(std::abs(q[3]), std::cos(half / 2), 1e-12);
}

TEST(TimeSeries, PosesMoveStraightWhileTurning) {
  TimeSeries series(pose_manifold());
  series.append(0, {0, 0, 0, 0, 0, 0, 1});
  series.append(1, {2, 4, 6, 0, 0, 1, 0});
  const std::vector<double> pose = series.interpolate(0.5);
  EXPECT_NEAR(pose[0], 1, 1e-12);
  EXPECT_NEAR(pose[2], 3, 1e-12);
}

}  // namespace
}  // namespace conddp
