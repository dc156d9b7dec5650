#include "nlp/pair_relaxation.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

constexpr PairRelaxation kAll[] = {PairRelaxation::elementwise, PairRelaxation::inner_product,
                                   PairRelaxation::fischer_burmeister, PairRelaxation::penalty};

TEST(PairRelaxation, DerivativesAgreeWithDifferences) {
  const double g[] = {0.3, 1.2, 0.02, 0.5}, h = 1e-6, epsilon = 0.01;
  for (const PairRelaxation way : kAll) {
    double slope[4];
    pair_value(way, g, 4, epsilon, slope);
    for (int i = 0; i < 4; ++i) {
      double up[4], down[4], slope_up[4], slope_down[4];
      std::copy_n(g, 4, up);
      std::copy_n(g, 4, down);
      up[i] += h;
      down[i] -= h;
      const double above = pair_value(way, up, 4, epsilon, slope_up);
      const double below = pair_value(way, down, 4, epsilon, slope_down);
      EXPECT_NEAR(slope[i], (above - below) / (2 * h), 1e-8);
      const int pair = i / 2 * 2;
      const Eigen::Vector3d second = pair_curvature(way, g[pair], g[pair + 1], epsilon);
      for (int j = 0; j < 2; ++j)
        EXPECT_NEAR(second[i - pair + j], (slope_up[pair + j] - slope_down[pair + j]) / (2 * h),
                    1e-6);
    }
  }
}

TEST(PairRelaxation, FischerBurmeisterMakesTheProductEpsilon) {
  const double epsilon = 1e-3;
  const double g[] = {0.5, epsilon / 0.5};
  EXPECT_NEAR(pair_value(PairRelaxation::fischer_burmeister, g, 2, epsilon, nullptr), 0, 1e-15);
}

}  // namespace
}  // namespace conddp
