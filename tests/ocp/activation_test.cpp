#include "ocp/terms/activation.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

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
