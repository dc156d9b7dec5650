#include "ocp/terms/activation.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/random_numbers.hpp"

namespace conddp {
namespace {

constexpr int kComponents = 3;

constexpr ActivationKind kActivations[] = {
    ActivationKind::quadratic, ActivationKind::quadratic_barrier, ActivationKind::smooth_l1,
    ActivationKind::smooth_l2, ActivationKind::linear};

Activation activation_of(ActivationKind kind, bool weighted) {
  Activation a{.kind = kind, .epsilon = 0.3};
  if (weighted) a.weights = {0.5, 2, 3};
  a.lower = {-0.5, 0.25, -std::numeric_limits<double>::infinity()};
  a.upper = {0.75, std::numeric_limits<double>::infinity(), 0.125};
  return a;
}

/// Activation by its definition.
double written_out(const Activation& a, const std::vector<double>& r) {
  double sum = 0;
  for (int i = 0; i < kComponents; ++i) {
    const double w = a.weights.empty() ? 1 : a.weights[i], e = a.epsilon;
    switch (a.kind) {
      case ActivationKind::quadratic:
        sum += 0.5 * w * r[i] * r[i];
        break;
      case ActivationKind::quadratic_barrier:
        sum += 0.5 * w *
               (std::pow(std::min(r[i] - a.lower[i], 0.0), 2) +
                std::pow(std::max(r[i] - a.upper[i], 0.0), 2));
        break;
      case ActivationKind::smooth_l1:
        sum += w * (std::sqrt(r[i] * r[i] + e * e) - e);
        break;
      case ActivationKind::smooth_l2:
        sum += w * r[i] * r[i];
        break;
      case ActivationKind::linear:
        sum += w * r[i];
        break;
    }
  }
  if (a.kind == ActivationKind::smooth_l2)
    return std::sqrt(sum + a.epsilon * a.epsilon) - a.epsilon;
  return sum;
}

template <class F>
void at_random_residuals(F test) {
  RandomNumbers random(41);
  for (const ActivationKind kind : kActivations)
    for (const bool weighted : {false, true})
      for (int i = 0; i < 20; ++i)
        test(activation_of(kind, weighted), random.numbers(kComponents, 1.5));
}

TEST(Activation, MatchesItsDefinition) {
  at_random_residuals([](const Activation& a, const std::vector<double>& r) {
    double gradient[kComponents], diagonal[kComponents], rank_one = 0;
    const double expected = written_out(a, r);
    EXPECT_NEAR(a.value(r.data(), kComponents), expected, 1e-13);
    EXPECT_NEAR(a.differentiate(r.data(), kComponents, gradient, diagonal, rank_one), expected,
                1e-13);
  });
}

TEST(Activation, DerivativesMatchDualNumbers) {
  using D = Dual<Lane>;
  at_random_residuals([](const Activation& a, const std::vector<double>& r) {
    double gradient[kComponents], diagonal[kComponents], rank_one = 0;
    a.differentiate(r.data(), kComponents, gradient, diagonal, rank_one);
    for (int j = 0; j < kComponents; ++j) {
      std::vector<D> moved(r.begin(), r.end());
      moved[j].d = Lane(1.0);
      EXPECT_NEAR(gradient[j], a.value(moved.data(), kComponents).d[0], 1e-13);
      D slopes[kComponents], unused[kComponents], none;
      a.differentiate(moved.data(), kComponents, slopes, unused, none);
      for (int i = 0; i < kComponents; ++i) {
        const double hessian = (i == j ? diagonal[i] : 0) + rank_one * gradient[i] * gradient[j];
        EXPECT_NEAR(hessian, slopes[i].d[0], 1e-13);
      }
    }
  });
}

TEST(Activation, BarrierIsFlatAtItsLimits) {
  const Activation a = activation_of(ActivationKind::quadratic_barrier, true);
  const double on_limits[] = {0.75, 0.25, 0.125};
  double gradient[kComponents], diagonal[kComponents], rank_one = 1;
  EXPECT_EQ(a.differentiate(on_limits, kComponents, gradient, diagonal, rank_one), 0);
  EXPECT_EQ(rank_one, 0);
  for (int i = 0; i < kComponents; ++i) EXPECT_EQ(diagonal[i], 0) << i;
}

TEST(Activation, SmoothNormsOfSmallResidualsAreExact) {
  // √(s + ε²) − ε = s/2ε − s²/8ε³ + ...
  constexpr double kEpsilon = 0.1, kSmall = 1e-7;
  const double expected = kSmall * kSmall / (2 * kEpsilon);
  for (const ActivationKind kind : {ActivationKind::smooth_l1, ActivationKind::smooth_l2}) {
    const Activation activation{.kind = kind, .epsilon = kEpsilon};
    double gradient = 0, diagonal = 0, rank_one = 0;
    EXPECT_NEAR(activation.value(&kSmall, 1), expected, 1e-11 * expected);
    EXPECT_NEAR(activation.differentiate(&kSmall, 1, &gradient, &diagonal, rank_one), expected,
                1e-11 * expected);
  }
}

}  // namespace
}  // namespace conddp
