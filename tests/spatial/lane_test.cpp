#include "spatial/lane.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/random_numbers.hpp"

namespace conddp {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Lane random_lane(RandomNumbers& random, double lower, double upper) {
  Lane a;
  for (int i = 0; i < kLaneWidth; ++i) a.set(i, random.uniform(lower, upper));
  return a;
}

/// Distance in units of the last place of the expected double.
double ulps(double actual, long double expected) {
  const double rounded = std::abs(static_cast<double>(expected));
  const double ulp = std::nextafter(rounded, kInfinity) - rounded;
  return static_cast<double>(std::abs(static_cast<long double>(actual) - expected) / ulp);
}

/// sincos of every angle in every lane.
template <class F>
void for_each_sincos(const std::vector<double>& angles, F test) {
  for (std::size_t i = 0; i < angles.size(); i += kLaneWidth) {
    Lane angle, s, c;
    for (int k = 0; k < kLaneWidth; ++k) angle.set(k, angles[(i + k) % angles.size()]);
    sincos(angle, s, c);
    for (int k = 0; k < kLaneWidth; ++k) test(angle[k], s[k], c[k]);
  }
}

double worst_ulps(const std::vector<double>& angles) {
  double worst = 0;
  for_each_sincos(angles, [&](double x, double s, double c) {
    worst = std::max({worst, ulps(s, std::sin(static_cast<long double>(x))),
                      ulps(c, std::cos(static_cast<long double>(x)))});
  });
  return worst;
}

TEST(Lane, ArithmeticMatchesDoubles) {
  RandomNumbers random(1);
  for (int n = 0; n < 100; ++n) {
    const Lane a = random_lane(random, -3, 3), b = random_lane(random, -3, 3);
    Lane sum = a, difference = a, product = a, quotient = a;
    sum += b;
    difference -= b;
    product *= b;
    quotient /= b;
    for (int i = 0; i < kLaneWidth; ++i) {
      EXPECT_EQ((a + b)[i], a[i] + b[i]);
      EXPECT_EQ((a - b)[i], a[i] - b[i]);
      EXPECT_EQ((a * b)[i], a[i] * b[i]);
      EXPECT_EQ((a / b)[i], a[i] / b[i]);
      EXPECT_EQ((-a)[i], -a[i]);
      EXPECT_EQ(sum[i], a[i] + b[i]);
      EXPECT_EQ(difference[i], a[i] - b[i]);
      EXPECT_EQ(product[i], a[i] * b[i]);
      EXPECT_EQ(quotient[i], a[i] / b[i]);
      EXPECT_EQ(min(a, b)[i], std::min(a[i], b[i]));
      EXPECT_EQ(max(a, b)[i], std::max(a[i], b[i]));
      EXPECT_EQ(abs(a)[i], std::abs(a[i]));
    }
  }
}

TEST(Lane, ConstantFillsAllLanes) {
  const Lane a = 2.5;
  for (int i = 0; i < kLaneWidth; ++i) EXPECT_EQ(a[i], 2.5);
}

TEST(Lane, FunctionsMatchDoubles) {
  RandomNumbers random(2);
  const Lane a = random_lane(random, 0.01, 0.99), b = random_lane(random, -2, 2);
  for (int i = 0; i < kLaneWidth; ++i) {
    EXPECT_EQ(sqrt(a)[i], std::sqrt(a[i]));
    EXPECT_EQ(exp(b)[i], std::exp(b[i]));
    EXPECT_EQ(log(a)[i], std::log(a[i]));
    EXPECT_EQ(tan(b)[i], std::tan(b[i]));
    EXPECT_EQ(asin(a)[i], std::asin(a[i]));
    EXPECT_EQ(acos(a)[i], std::acos(a[i]));
    EXPECT_EQ(atan2(a, b)[i], std::atan2(a[i], b[i]));
    EXPECT_LE(ulps(sin(b)[i], std::sin(static_cast<long double>(b[i]))), 2);
    EXPECT_LE(ulps(cos(b)[i], std::cos(static_cast<long double>(b[i]))), 2);
  }
}

TEST(Lane, ComparisonsSelectLaneByLane) {
  RandomNumbers random(3);
  Lane a = random_lane(random, -1, 1);
  const Lane b = random_lane(random, -1, 1);
  a.set(0, b[0]);
  for (int i = 0; i < kLaneWidth; ++i) {
    EXPECT_EQ(select(a < b, Lane(1.0), Lane(2.0))[i], a[i] < b[i] ? 1 : 2);
    EXPECT_EQ(select(a <= b, Lane(1.0), Lane(2.0))[i], a[i] <= b[i] ? 1 : 2);
    EXPECT_EQ(select(a > b, Lane(1.0), Lane(2.0))[i], a[i] > b[i] ? 1 : 2);
    EXPECT_EQ(select(a >= b, Lane(1.0), Lane(2.0))[i], a[i] >= b[i] ? 1 : 2);
    EXPECT_EQ(select(a == b, Lane(1.0), Lane(2.0))[i], a[i] == b[i] ? 1 : 2);
    EXPECT_EQ(select(!(a == b), Lane(1.0), Lane(2.0))[i], a[i] == b[i] ? 2 : 1);
    EXPECT_EQ(select((a < b) | (a > b), Lane(1.0), Lane(2.0))[i], a[i] == b[i] ? 2 : 1);
    EXPECT_EQ(select((a <= b) & (a >= b), Lane(1.0), Lane(2.0))[i], a[i] == b[i] ? 1 : 2);
  }
}

TEST(Lane, AnyFindsOneLane) {
  EXPECT_FALSE(any(Lane(1.0) < Lane(1.0)));
  for (int i = 0; i < kLaneWidth; ++i) {
    Lane a = 1.0;
    a.set(i, 0.5);
    EXPECT_TRUE(any(a < Lane(1.0)));
  }
}

TEST(Lane, NaNComparesFalse) {
  const Lane nan = kNaN;
  EXPECT_FALSE(any(nan < Lane(0.0)));
  EXPECT_FALSE(any(nan >= Lane(0.0)));
  EXPECT_FALSE(any(nan == nan));
}

TEST(LaneSincos, IsWithinTwoUlpsToAThousand) {
  RandomNumbers random(4);
  std::vector<double> angles;
  for (const double range : {1e-8, 1e-3, 0.1, 0.8, 1.6, 3.2, 10.0, 100.0, 1000.0})
    for (int i = 0; i < 20000; ++i) angles.push_back(random.uniform(-range, range));
  EXPECT_LE(worst_ulps(angles), 2);
}

// One of the two nearly vanishes there, or the quadrant changes.
TEST(LaneSincos, IsAccurateAroundMultiplesOfAnEighthTurn) {
  std::vector<double> angles;
  for (int k = -1280; k <= 1280; ++k) {
    const double x = k * (M_PI / 4);
    for (const double near : {x, std::nextafter(x, 1e9), std::nextafter(x, -1e9), x * (1 + 1e-12)})
      angles.push_back(near);
  }
  EXPECT_LE(worst_ulps(angles), 2);
}

TEST(LaneSincos, StaysAccurateForLargeAngles) {
  RandomNumbers random(5);
  std::vector<double> angles;
  for (const double range : {1e4, 1e5, 1.1e5, 1e8, 1e15, 1e300})
    for (int i = 0; i < 5000; ++i) angles.push_back(random.uniform(-range, range));
  double worst = 0;
  for_each_sincos(angles, [&](double x, double s, double c) {
    worst = std::max({worst, std::abs(s - std::sin(x)), std::abs(c - std::cos(x))});
  });
  EXPECT_LE(worst, 4e-16);
}

TEST(LaneSincos, SignedZeroIsExact) {
  Lane s, c;
  sincos(Lane(0.0), s, c);
  for (int i = 0; i < kLaneWidth; ++i) {
    EXPECT_EQ(s[i], 0);
    EXPECT_EQ(c[i], 1);
  }
}

TEST(LaneSincos, NaNAndInfinityStayInTheirLane) {
  RandomNumbers random(6);
  const Lane clean = random_lane(random, -3, 3);
  Lane clean_s, clean_c;
  sincos(clean, clean_s, clean_c);
  for (const double rubbish : {kNaN, kInfinity, -kInfinity})
    for (int bad = 0; bad < kLaneWidth; ++bad) {
      Lane angle = clean, s, c;
      angle.set(bad, rubbish);
      sincos(angle, s, c);
      for (int i = 0; i < kLaneWidth; ++i) {
        if (i == bad) {
          EXPECT_TRUE(std::isnan(s[i]) && std::isnan(c[i]));
        } else {
          EXPECT_EQ(s[i], clean_s[i]);
          EXPECT_EQ(c[i], clean_c[i]);
        }
      }
    }
}

}  // namespace
}  // namespace conddp
