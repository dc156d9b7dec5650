#include "systems/graphs/spline_table.hpp"

#include <cmath>
#include <stdexcept>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "support/random_numbers.hpp"

namespace conddp {
namespace {

/// Ascending points with steps between 0.3 and 1.
std::vector<double> spline_points(int count, RandomNumbers& random) {
  std::vector<double> points{random.uniform(-2, 0)};
  for (int i = 1; i < count; ++i) points.push_back(points.back() + random.uniform(0.3, 1));
  return points;
}

/// Checks the derivative with respect to x against differences of the next lower order from either
/// side, including where pieces meet.
void expect_smooth(const SplineTable& table, double x, double y) {
  constexpr double h = 1e-5;
  for (int order = 0; order < 2; ++order)
    for (const double side : {-1.0, 1.0}) {
      const double slope =
          (table.derivative(order, 0, x + side * h, y) - table.derivative(order, 0, x, y)) /
          (side * h);
      EXPECT_NEAR(slope, table.derivative(order + 1, 0, x, y), 1e-3) << order << " at " << x;
    }
  EXPECT_NEAR(table.derivative(2, 0, x - 1e-9, y), table.derivative(2, 0, x + 1e-9, y), 1e-6);
}

TEST(SplineTables, SplineOfFourPointsSolvesItsEquations) {
  // Three cubics a + b s + c s² + d s³: values, two matching derivatives, natural ends.
  RandomNumbers random(321);
  const std::vector<double> x = spline_points(4, random), v = random.numbers(4, 2);
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(12, 12);
  Eigen::VectorXd b = Eigen::VectorXd::Zero(12);
  int row = 0;
  for (int i = 0; i < 3; ++i) {
    const double h = x[i + 1] - x[i];
    A(row, 4 * i) = 1;
    b[row++] = v[i];
    A.block<1, 4>(row, 4 * i) << 1, h, h * h, h * h * h;
    b[row++] = v[i + 1];
    if (i == 2) break;
    A.block<1, 4>(row, 4 * i) << 0, 1, 2 * h, 3 * h * h;
    A(row++, 4 * i + 5) = -1;
    A.block<1, 4>(row, 4 * i) << 0, 0, 2, 6 * h;
    A(row++, 4 * i + 6) = -2;
  }
  A(row++, 2) = 1;
  A.block<1, 4>(row, 8) << 0, 0, 2, 6 * (x[3] - x[2]);
  const Eigen::VectorXd c = A.fullPivLu().solve(b);
  const SplineTable table(x, v);
  for (int i = 0; i < 3; ++i)
    for (const double share : {0.0, 0.2, 0.7}) {
      const double s = share * (x[i + 1] - x[i]), at = x[i] + s;
      const auto k = c.segment<4>(4 * i);
      EXPECT_NEAR(table.derivative(0, 0, at, 0), k[0] + s * (k[1] + s * (k[2] + s * k[3])), 1e-13);
      EXPECT_NEAR(table.derivative(1, 0, at, 0), k[1] + s * (2 * k[2] + 3 * s * k[3]), 1e-12);
      EXPECT_NEAR(table.derivative(2, 0, at, 0), 2 * k[2] + 6 * s * k[3], 1e-12);
      EXPECT_NEAR(table.derivative(3, 0, at, 0), 6 * k[3], 1e-11);
    }
}

TEST(SplineTables, PassThroughTheirValuesTwiceSmoothly) {
  RandomNumbers random(322);
  const std::vector<double> x = spline_points(7, random), v = random.numbers(7, 2);
  const SplineTable table(x, v);
  for (int i = 0; i < 7; ++i) {
    EXPECT_NEAR(table.derivative(0, 0, x[i], 0), v[i], 1e-14);
    expect_smooth(table, x[i], 0);
  }
}

TEST(SplineTables, AreLinearBeyondTheEnds) {
  RandomNumbers random(323);
  const std::vector<double> x = spline_points(5, random), v = random.numbers(5, 2);
  const SplineTable table(x, v);
  for (const bool left : {true, false}) {
    const double end = left ? x.front() : x.back(), at = left ? end - 3 : end + 3;
    const double slope = table.derivative(1, 0, end, 0);
    EXPECT_EQ(table.derivative(1, 0, at, 0), slope);
    EXPECT_NEAR(table.derivative(0, 0, at, 0), table.derivative(0, 0, end, 0) + slope * (at - end),
                1e-13);
    EXPECT_EQ(table.derivative(2, 0, at, 0), 0);
    EXPECT_EQ(table.derivative(3, 0, at, 0), 0);
  }
}

TEST(SplineTables, TwoPointsGiveALine) {
  const SplineTable table({1, 3}, {2, 8});
  for (const double x : {-4.0, 1.0, 1.7, 9.0}) {
    EXPECT_NEAR(table.derivative(0, 0, x, 0), 2 + 3 * (x - 1), 1e-14);
    EXPECT_NEAR(table.derivative(1, 0, x, 0), 3, 1e-15);
  }
}

TEST(SplineTables, TwoArgumentTableFactorsIntoOneArgumentTables) {
  // The values f(x) g(y) have the product of the splines of f and g.
  RandomNumbers random(324);
  const std::vector<double> x = spline_points(5, random), y = spline_points(6, random);
  const std::vector<double> f = random.numbers(5, 2), g = random.numbers(6, 2);
  std::vector<double> values;
  for (const double a : f)
    for (const double b : g) values.push_back(a * b);
  const SplineTable table(x, y, values), of_x(x, f), of_y(y, g);
  EXPECT_EQ(table.arguments(), 2);
  EXPECT_EQ(table.first(1), y.front());
  EXPECT_EQ(table.last(0), x.back());
  for (int repeat = 0; repeat < 50; ++repeat) {
    const double a = random.uniform(x.front() - 1, x.back() + 1);
    const double b = random.uniform(y.front() - 1, y.back() + 1);
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const double expected = of_x.derivative(i, 0, a, 0) * of_y.derivative(j, 0, b, 0);
        EXPECT_NEAR(table.derivative(i, j, a, b), expected, 1e-12 * (1 + std::abs(expected)));
      }
  }
  expect_smooth(table, x[2], 0.3);
}

TEST(SplineTables, DualNumbersAndLanesMoveWithTheTable) {
  const SplineTable table({0, 1, 3}, {0, 1}, {1, 2, 0, 3, 1, 5});
  const Dual<Lane> x(Lane(0.4), Lane(2.0)), y(Lane(0.3), Lane(-1.0));
  const Dual<Lane> value = table_value(table, 0, 1, x, y);
  EXPECT_EQ(value.v[0], table.derivative(0, 1, 0.4, 0.3));
  EXPECT_NEAR(value.d[0], 2 * table.derivative(1, 1, 0.4, 0.3) - table.derivative(0, 2, 0.4, 0.3),
              1e-15);
}

TEST(SplineTables, NeedAscendingPointsAndAValueForEach) {
  EXPECT_THROW(SplineTable({1}, {1}), std::invalid_argument);
  EXPECT_THROW(SplineTable({1, 1}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(SplineTable({1, 0}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(SplineTable({0, 1}, std::vector<double>{1, 2, 3}), std::invalid_argument);
  EXPECT_THROW(SplineTable({0, 1}, {1, NAN}), std::invalid_argument);
  EXPECT_THROW(SplineTable({0, INFINITY}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(SplineTable({0, 1}, {0, 1}, {1, 2, 3}), std::invalid_argument);
  EXPECT_THROW(SplineTable({0, 1}, {0}, {1, 2}), std::invalid_argument);
  EXPECT_THROW(SplineTable({0, 1}, {0, 1}, {1, 2, 3, INFINITY}), std::invalid_argument);
}

}  // namespace
}  // namespace conddp
