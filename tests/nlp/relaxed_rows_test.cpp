#include "nlp/relaxed_rows.hpp"

#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "ocp/terms/constraint.hpp"
#include "support/nlp_derivatives.hpp"

namespace conddp {
namespace {

using Eigen::Vector3d;

constexpr std::array kConeForms = {ConeRow::Form::surface, ConeRow::Form::distance};

Vector3d cone_slope(const ConeRow& row, const Vector3d& g) {
  Vector3d slope;
  row.value(g.data(), 3, slope.data());
  return slope;
}

TEST(ConeRow, DerivativesMatchDifferencesAlsoAtTheTip) {
  std::mt19937_64 engine(1);
  constexpr double kStep = 1e-6;
  for (const ConeRow::Form form : kConeForms)
    for (const Vector3d& g :
         {Vector3d(0.3, -0.2, 0.7), Vector3d(0, 0, 0.5), Vector3d(1, 2, -0.4), Vector3d(0, 0, 0)}) {
      const ConeRow row{form, 0.1};
      const Eigen::MatrixXd C = Eigen::MatrixXd::Random(3, 4);
      Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(4, 4);
      row.add_curvature(g, C, 0.7, curvature);
      const Eigen::VectorXd d = testing::random_vector(4, engine);
      const Vector3d ahead = g + kStep * C * d, behind = g - kStep * C * d;
      EXPECT_NEAR((row.value(ahead.data(), 3, nullptr) - row.value(behind.data(), 3, nullptr)) /
                      (2 * kStep),
                  cone_slope(row, g).dot(C * d), 1e-8);
      const Eigen::VectorXd bend =
          C.transpose() * (cone_slope(row, ahead) - cone_slope(row, behind)) / (2 * kStep);
      EXPECT_LE((0.7 * bend - curvature * d).lpNorm<Eigen::Infinity>(), 1e-7);
    }
}

TEST(ConeRow, IsPositiveInsideAndNegativeOutside) {
  for (const ConeRow::Form form : kConeForms) {
    const ConeRow row{form, 1e-9};
    for (const double share : {0.0, 0.5, 0.99, 1.01, 2.0}) {
      const Vector3d g(0.6 * share, 0.8 * share, 1);
      EXPECT_EQ(row.value(g.data(), 3, nullptr) > 0, share < 1) << share;
    }
    const Vector3d below(0.1, 0, -1);
    EXPECT_LT(row.value(below.data(), 3, nullptr), 0);
  }
}

TEST(ConeRow, SmoothingErrorIsBounded) {
  std::mt19937_64 engine(2);
  for (const ConeRow::Form form : kConeForms)
    for (int i = 0; i < 100; ++i) {
      const Vector3d g = testing::random_vector(3, engine);
      const double smooth = ConeRow{form, 0.01}.value(g.data(), 3, nullptr);
      const double sharp = ConeRow{form, 0}.value(g.data(), 3, nullptr);
      EXPECT_GE(smooth, sharp);
      EXPECT_LE(smooth, sharp + 0.01);
    }
}

TEST(ConeRow, DistanceMeasuresHowFarOutsidePointsAre) {
  const ConeRow row{ConeRow::Form::distance, 0};
  const Vector3d g(3, 4, 1);
  Vector3d outside;
  outside_cone(g.data(), 3, outside.data());
  EXPECT_NEAR(-row.value(g.data(), 3, nullptr), std::numbers::sqrt2 * outside.norm(), 1e-14);
}

/// Forces of feet at rest lie on the axis.
TEST(ConeRow, SurfaceCurvatureOnAxisFollowsHeightAboveTip) {
  Eigen::MatrixXd curvature = Eigen::MatrixXd::Zero(3, 3);
  ConeRow{ConeRow::Form::surface, 1e-9}.add_curvature(
      Vector3d(0, 0, 5), Eigen::MatrixXd::Identity(3, 3), 1, curvature);
  EXPECT_LE((curvature + Vector3d(0.2, 0.2, 0).asDiagonal().toDenseMatrix()).norm(), 1e-12);
}

TEST(ConeRow, HasMultipliersInThePolarConeEverywhere) {
  std::mt19937_64 engine(3);
  for (const ConeRow::Form form : kConeForms)
    for (int i = 0; i < 100; ++i) {
      const Vector3d nu = -cone_slope({form, 0.01}, testing::random_vector(3, engine));
      EXPECT_LE(nu.head(2).norm(), -nu[2] + 1e-15);
    }
}

TEST(ConeRow, FindsMultiplierOfASurfaceVector) {
  for (const ConeRow::Form form : kConeForms) {
    const ConeRow row{form, 0};
    const Vector3d nu = -2.5 * cone_slope(row, Vector3d(1.8, 2.4, 3));
    EXPECT_NEAR(row.multiplier(nu.data(), 3), -2.5, 1e-14);
  }
  const Vector3d slope = cone_slope({ConeRow::Form::surface, 0}, Vector3d(1.8, 2.4, 3));
  EXPECT_NEAR(slope.norm(), 1, 1e-15);
}

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
