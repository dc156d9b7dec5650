#include "analysis/contact/contact_sweeps.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(NearestFriction, ProjectsOntoDiscAndPyramidRims) {
  const Eigen::Vector2d inside(0.3, -0.2), outside(3, -4);
  for (const bool pyramid : {false, true})
    EXPECT_EQ(nearest_friction(inside, 1, pyramid), inside) << pyramid;
  EXPECT_LT((nearest_friction(outside, 1, false) - Eigen::Vector2d(0.6, -0.8)).norm(), 1e-15);
  EXPECT_LT((nearest_friction(outside, 1, true) - Eigen::Vector2d(0, -1)).norm(), 1e-15);
  EXPECT_LT((nearest_friction({2, -2.5}, 1, true) - Eigen::Vector2d(0.25, -0.75)).norm(), 1e-15);
  EXPECT_EQ(nearest_friction(outside, -1, false), Eigen::Vector2d(0, 0));
}

/// A mass of 2 kg on the floor: velocities are the impulse-free ones plus p/2.
struct Mass {
  Eigen::MatrixXd D = 0.5 * Eigen::Matrix3d::Identity();
  std::vector<ImpulseBound> bounds{{.normal = 0, .tangent = 1, .tangents = 2, .friction = 0.5}};
  Eigen::VectorXd p = Eigen::Vector3d::Zero();

  Eigen::Vector3d meet(const Eigen::Vector3d& free) {
    sweep_impulses(D, free, bounds, 1, p);
    const Eigen::Vector3d u = free + D * p;
    EXPECT_LT(impulse_residual(u, bounds, 1, p), 1e-14);
    return u;
  }
};

TEST(ImpulseSweeps, StopSlowContactsAndOpposeFastSlip) {
  Mass stuck;
  EXPECT_LT(stuck.meet({-1, 0.3, 0.4}).norm(), 1e-14);
  EXPECT_LT((stuck.p - Eigen::Vector3d(2, -0.6, -0.8)).norm(), 1e-14);
  Mass sliding;  // speed of 5 m/s decreases by μ p_n / m
  EXPECT_LT((sliding.meet({-1, 3, 4}) - Eigen::Vector3d(0, 2.7, 3.6)).norm(), 1e-14);
  Mass leaving;
  EXPECT_EQ(leaving.meet({1, 3, 4}), Eigen::Vector3d(1, 3, 4));
  EXPECT_EQ(leaving.p.norm(), 0);
}

TEST(ImpulseSweeps, ShareALoadThatRowsCarryTogether) {
  // Two contacts under one mass of 1 kg: D is singular.
  const Eigen::Matrix2d D = Eigen::Matrix2d::Ones();
  const std::vector<ImpulseBound> bounds{{.normal = 0}, {.normal = 1}};
  Eigen::VectorXd p = Eigen::Vector2d::Zero();
  const Eigen::Vector2d free(-1, -1);
  EXPECT_LT(sweep_impulses(D, free, bounds, 1, p), 1e-15);
  EXPECT_NEAR(p.sum(), 1, 1e-14);
  EXPECT_GE(p.minCoeff(), 0);
  EXPECT_LT(impulse_residual(free + D * p, bounds, 1, p), 1e-14);
}

}  // namespace
}  // namespace conddp
