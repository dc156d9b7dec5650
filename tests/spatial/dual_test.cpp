#include "spatial/dual.hpp"

#include <cmath>
#include <complex>

#include <gtest/gtest.h>

#include "support/random_numbers.hpp"

namespace conddp {
namespace {

using Complex = std::complex<double>;
using D = Dual<double>;

/// f'(x) of an analytic function by a complex step, exact to rounding.
template <class F>
double complex_step(F f, double x) {
  const double h = 1e-100;
  return f(Complex(x, h)).imag() / h;
}

/// A function in dual numbers, compared with its complex step at random points.
template <class F>
void expect_complex_step(F f, double lower, double upper, const char* name) {
  RandomNumbers random(1);
  for (int i = 0; i < 50; ++i) {
    const double x = random.uniform(lower, upper);
    const D y = f(D(x, 1.0));
    EXPECT_NEAR(y.v, f(Complex(x)).real(), 1e-14 * (1 + std::abs(y.v))) << name << " at " << x;
    const double slope = complex_step(f, x);
    EXPECT_NEAR(y.d, slope, 1e-13 * (1 + std::abs(slope))) << name << " at " << x;
  }
}

TEST(Dual, FunctionsHaveTheirDerivatives) {
  expect_complex_step([](auto x) { return sin(x); }, -4, 4, "sin");
  expect_complex_step([](auto x) { return cos(x); }, -4, 4, "cos");
  expect_complex_step([](auto x) { return tan(x); }, -1.4, 1.4, "tan");
  expect_complex_step([](auto x) { return asin(x); }, -0.9, 0.9, "asin");
  expect_complex_step([](auto x) { return acos(x); }, -0.9, 0.9, "acos");
  expect_complex_step([](auto x) { return exp(x); }, -3, 3, "exp");
  expect_complex_step([](auto x) { return log(x); }, 0.1, 5, "log");
  expect_complex_step([](auto x) { return sqrt(x); }, 0.1, 5, "sqrt");
}

TEST(Dual, ArithmeticHasItsDerivatives) {
  expect_complex_step([](auto x) { return x * x + x - sin(x); }, -2, 2, "sums");
  expect_complex_step([](auto x) { return (x * x + exp(x)) / (x - sin(x) * x * x); }, 1.2, 2,
                      "quotients");
  expect_complex_step([](auto x) { return 2.0 * x - x * 3.0 - (-x); }, -2, 2, "constants");
  expect_complex_step(
      [](auto x) {
        auto y = x;
        y *= x;
        y += exp(x);
        y -= x * x * x;
        y /= x + x * x;
        return y;
      },
      0.5, 2, "assignments");
}

TEST(Dual, ArcTangentOfTwoHasItsGradient) {
  RandomNumbers random(2);
  for (int i = 0; i < 100; ++i) {
    const double y = random.uniform(-2, 2), x = random.uniform(-2, 2);
    const double dy = random.uniform(-1, 1), dx = random.uniform(-1, 1);
    const double h = 1e-6;
    const auto along = [&](double t) { return std::atan2(y + t * dy, x + t * dx); };
    const double r2 = x * x + y * y;
    if (r2 < 0.1 || (x < 0 && std::abs(y) < 1e-3)) continue;
    const D angle = atan2(D(y, dy), D(x, dx));
    EXPECT_EQ(angle.v, std::atan2(y, x));
    EXPECT_NEAR(angle.d, (along(h) - along(-h)) / (2 * h), 1e-8);
  }
}

TEST(Dual, SelectionsFollowTheValue) {
  const D a(1.0, 10.0), b(2.0, 20.0), c(-3.0, 30.0);
  EXPECT_EQ(min(a, b).d, 10);
  EXPECT_EQ(max(a, b).d, 20);
  EXPECT_EQ(abs(a).d, 10);
  EXPECT_EQ(abs(c).v, 3);
  EXPECT_EQ(abs(c).d, -30);
  EXPECT_EQ(select(a < b, a, b).d, 10);
  EXPECT_EQ(select(a > b, a, b).d, 20);
}

// sin(x) eˣ has the second derivative 2 cos(x) eˣ.
TEST(Dual, NestsForSecondDerivatives) {
  const double x = 0.7;
  const Dual<D> y(D(x, 1.0), D(1.0, 0.0));
  const Dual<D> z = sin(y) * exp(y);
  EXPECT_NEAR(z.v.d, (std::sin(x) + std::cos(x)) * std::exp(x), 1e-14);
  EXPECT_NEAR(z.d.v, (std::sin(x) + std::cos(x)) * std::exp(x), 1e-14);
  EXPECT_NEAR(z.d.d, 2 * std::cos(x) * std::exp(x), 1e-14);
}

TEST(Dual, OverLanesEqualsOverDoubles) {
  RandomNumbers random(3);
  Dual<Lane> wide;
  std::vector<D> narrow;
  for (int i = 0; i < kLaneWidth; ++i) {
    narrow.emplace_back(random.uniform(0.2, 0.8), random.uniform(-1, 1));
    wide.v.set(i, narrow[i].v);
    wide.d.set(i, narrow[i].d);
  }
  const auto f = [](const auto& x) {
    return sin(x) * exp(x) / (x + sqrt(x)) - atan2(cos(x), x) * log(x) + asin(x) * acos(x) +
           max(tan(x), abs(-x)) * min(x, x * x);
  };
  const Dual<Lane> all = f(wide);
  for (int i = 0; i < kLaneWidth; ++i) {
    const D one = f(narrow[i]);
    EXPECT_NEAR(all.v[i], one.v, 1e-14);
    EXPECT_NEAR(all.d[i], one.d, 1e-13);
  }
}

}  // namespace
}  // namespace conddp
