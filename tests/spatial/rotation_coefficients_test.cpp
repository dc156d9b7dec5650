#include <cmath>

#include <gtest/gtest.h>

#include "spatial/dual.hpp"
#include "spatial/so3.hpp"

namespace conddp {
namespace {

/// Σ (−t)^k / (2k + n)! and its derivative in t; in long double, cancellation costs no digit of a
/// double for t < 40.
struct Series {
  long double value = 0, slope = 0;
  Series(long double t, int n) {
    long double term = 1;
    for (int i = 2; i <= n; ++i) term /= i;
    long double slope_term = 0;  // derivative of the term
    for (int k = 0; k < 40; ++k) {
      value += term;
      slope += slope_term;
      const long double factor = 1.0L / ((2 * k + n + 1.0L) * (2 * k + n + 2.0L));
      slope_term = -(term + t * slope_term) * factor;
      term *= -t * factor;
    }
  }
};

/// (3c − b)/(2t) = (d − 3 (1/6 − c)/t)/2, in long double.
struct LastReference {
  long double value, slope;
  explicit LastReference(long double t) {
    const Series d(t, 4), e(t, 5);
    value = (d.value - 3 * e.value) / 2;
    slope = (d.slope - 3 * e.slope) / 2;
  }
};

/// (1 − a/(2b))/t without cancellation: (2b − a)/(2bt), where the series of 2b − a starts with t.
struct InverseReference {
  long double value, slope;
  explicit InverseReference(long double t) {
    // n(t) = (2b − a)/t = Σ (−1)^k t^(k−1) (1/(k+1) − 1)/(2k+1)! for k ≥ 1.
    long double n = 0, dn = 0, power = 1, dpower = 0, factorial = 6;
    for (int k = 1; k < 40; ++k) {
      const long double c = (k % 2 == 1 ? 1.0L : -1.0L) * (k / (k + 1.0L)) / factorial;
      n += c * power;
      dn += c * dpower;
      dpower = k * power;
      power *= t;
      factorial *= (2 * k + 2.0L) * (2 * k + 3.0L);
    }
    const Series b(t, 2);
    value = n / (2 * b.value);
    slope = (dn - n * b.slope / b.value) / (2 * b.value);
  }
};

/// Angles around series thresholds, around π, and in between.
std::vector<double> squared_angles() {
  std::vector<double> t = {0, 1e-300, 1e-30, 1e-16, 1e-8, 1e-4, 1e-2, 0.1, 0.2};
  for (const double around : {0.25, 1.0, M_PI * M_PI})
    for (const double off : {-1e-2, -1e-6, -1e-12, 0.0, 1e-12, 1e-6, 1e-2})
      t.push_back(around * (1 + off));
  for (double x = 0.3; x < 36; x *= 1.07) t.push_back(x);
  return t;
}

void expect_relative(double actual, long double expected, double tolerance, double t,
                     const char* name) {
  EXPECT_LE(std::abs(static_cast<double>(actual - expected)),
            tolerance * std::abs(static_cast<double>(expected)))
      << name << " at " << t << ": " << actual << ", not " << static_cast<double>(expected);
}

// Beyond the threshold t = ¼, cancellation costs b, c, d, e at most their last one, two, three,
// four digits, and leaves the first ten digits of their derivatives.
TEST(RotationCoefficients, AreAccurateAroundTheSeriesThreshold) {
  for (const double t : squared_angles()) {
    if (t > 10.5) continue;
    const RotationCoefficients<double> k(t);
    expect_relative(k.b, Series(t, 2).value, 2e-15, t, "b");
    expect_relative(k.c, Series(t, 3).value, 5e-15, t, "c");
    expect_relative(k.d, Series(t, 4).value, 1e-13, t, "d");
    expect_relative(k.e, LastReference(t).value, 1e-12, t, "e");
    expect_relative(k.inv, InverseReference(t).value, 3e-14, t, "inv");
    EXPECT_NEAR(k.a, static_cast<double>(Series(t, 1).value), 1e-15);
  }
}

TEST(RotationCoefficients, HaveAccurateDerivatives) {
  for (const double t : squared_angles()) {
    if (t > 10.5) continue;
    const RotationCoefficients<Dual<double>> k(Dual<double>(t, 1.0));
    expect_relative(k.a.d, Series(t, 1).slope, 1e-14, t, "a");
    expect_relative(k.b.d, Series(t, 2).slope, 1e-13, t, "b");
    expect_relative(k.c.d, Series(t, 3).slope, 1e-12, t, "c");
    expect_relative(k.d.d, Series(t, 4).slope, 1e-11, t, "d");
    expect_relative(k.e.d, LastReference(t).slope, 1e-10, t, "e");
    expect_relative(k.inv.d, InverseReference(t).slope, 1e-11, t, "inv");
  }
}

TEST(RotationCoefficients, StayAccurateBeyondAHalfTurn) {
  for (const double t : squared_angles()) {
    const RotationCoefficients<double> k(t);
    EXPECT_NEAR(k.a, static_cast<double>(Series(t, 1).value), 1e-14);
    EXPECT_NEAR(k.b, static_cast<double>(Series(t, 2).value), 1e-14);
    EXPECT_NEAR(k.c, static_cast<double>(Series(t, 3).value), 1e-14);
    EXPECT_NEAR(k.d, static_cast<double>(Series(t, 4).value), 1e-14);
    EXPECT_NEAR(k.e, static_cast<double>(LastReference(t).value), 1e-14);
  }
}

// Formulas with powers of θ would cancel there.
TEST(RotationCoefficients, AreAccurateAfterManyTurns) {
  for (const double angle : {20.0, 1e3, 1e7}) {
    const RotationCoefficients<double> k(angle * angle);
    const long double t = angle, s = std::sin(t), c = std::cos(t);
    expect_relative(k.c, (t - s) / (t * t * t), 1e-15, angle, "c");
    expect_relative(k.d, (t * t / 2 - 1 + c) / (t * t * t * t), 1e-15, angle, "d");
    expect_relative(k.e, (2 * t - 3 * s + t * c) / (2 * t * t * t * t * t), 1e-14, angle, "e");
  }
}

}  // namespace
}  // namespace conddp
