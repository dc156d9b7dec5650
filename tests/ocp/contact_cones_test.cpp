#include <cmath>
#include <numbers>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "ocp/residuals/residuals.hpp"
#include "support/random_numbers.hpp"

namespace conddp {
namespace {

using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

bool inside(const LinearCone& cone, const VectorXd& f, double tolerance = 1e-9) {
  const VectorXd r = cone.A * f;
  for (int i = 0; i < r.size(); ++i)
    if (r[i] < cone.lower[i] - tolerance || r[i] > cone.upper[i] + tolerance) return false;
  return true;
}

Vector3<double> random_normal(RandomNumbers& random) {
  Vector3<double> n{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  return (1 / std::sqrt(squared_norm(n))) * n;
}

TEST(FrictionPyramid, InnerFitsTheConeAndOuterContainsIt) {
  RandomNumbers random(3);
  for (const int faces : {3, 4, 5, 8})
    for (int trial = 0; trial < 50; ++trial) {
      const double mu = random.uniform(0.1, 1.2);
      const Vector3<double> n = random_normal(random);
      const Vector3d normal(n.x, n.y, n.z);
      const LinearCone inner = friction_pyramid({.friction = mu}, faces, true, n);
      const LinearCone outer = friction_pyramid({.friction = mu}, faces, false, n);
      for (int sample = 0; sample < 50; ++sample) {
        const Vector3d f(random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(-2, 2));
        const double along = f.dot(normal);
        const double across = (f - along * normal).norm();
        const bool in_cone = across <= mu * along;
        EXPECT_TRUE(!inside(inner, f, -1e-9) || in_cone);
        EXPECT_TRUE(!in_cone || inside(outer, f));
      }
    }
}

TEST(FrictionPyramid, TouchesTheConeAtFacesOrEdges) {
  const double mu = 0.6;
  for (const int faces : {3, 4, 6}) {
    const LinearCone outer = friction_pyramid({.friction = mu}, faces, false, {0, 0, 1});
    const LinearCone inner = friction_pyramid({.friction = mu}, faces, true, {0, 0, 1});
    for (int i = 0; i < faces; ++i) {
      const double face = 2 * std::numbers::pi * i / faces, edge = face + std::numbers::pi / faces;
      const Vector3d on_face(mu * std::cos(face), mu * std::sin(face), 1);
      const Vector3d on_edge(mu * std::cos(edge), mu * std::sin(edge), 1);
      EXPECT_NEAR((outer.A * on_face)[i], 0, 1e-12);
      EXPECT_NEAR((inner.A * on_edge)[i], 0, 1e-12);
    }
  }
}

TEST(WrenchCone, InnerFitsTheConeAndOuterContainsIt) {
  RandomNumbers random(5);
  const double mu = 0.7, half_x = 0.1, half_y = 0.05;
  const LinearCone inner = wrench_cone({.friction = mu}, half_x, half_y, true);
  const LinearCone outer = wrench_cone({.friction = mu}, half_x, half_y, false);
  int between = 0;
  for (int sample = 0; sample < 500; ++sample) {
    // A force at the sole's center.
    VectorXd wrench = VectorXd::Zero(6);
    wrench.head(3) << random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(0, 1.5);
    const bool in_cone = wrench.head(2).norm() <= mu * wrench[2];
    EXPECT_TRUE(!inside(inner, wrench, -1e-9) || in_cone);
    EXPECT_TRUE(!in_cone || inside(outer, wrench));
    between += inside(outer, wrench) && !inside(inner, wrench);
  }
  EXPECT_GT(between, 0);
  // Along an axis, the outer cone carries μ f_z, the inner cone μ f_z / √2.
  VectorXd along = VectorXd::Zero(6);
  along[2] = 1;
  along[0] = 0.99 * mu;
  EXPECT_TRUE(inside(outer, along));
  EXPECT_FALSE(inside(inner, along));
  along[0] = 0.99 * mu / std::sqrt(2.0);
  EXPECT_TRUE(inside(inner, along));
}

TEST(FrictionPyramid, NormalForceHasItsLimits) {
  const LinearCone cone =
      friction_pyramid({.friction = 1, .min_normal = 5, .max_normal = 20}, 4, false, {0, 0.6, 0.8});
  EXPECT_FALSE(inside(cone, 4 * Vector3d(0, 0.6, 0.8)));
  EXPECT_TRUE(inside(cone, 6 * Vector3d(0, 0.6, 0.8)));
  EXPECT_FALSE(inside(cone, 21 * Vector3d(0, 0.6, 0.8)));
}

TEST(FrictionPyramid, RejectsInvalidCones) {
  EXPECT_THROW(friction_pyramid({.friction = 0}, 4, true, {0, 0, 1}), std::invalid_argument);
  EXPECT_THROW(friction_pyramid({}, 2, true, {0, 0, 1}), std::invalid_argument);
  EXPECT_THROW(friction_pyramid({.min_normal = 3, .max_normal = 2}, 4, true, {0, 0, 1}),
               std::invalid_argument);
}

/// Wrenches of unit forces along the edges of four-sided pyramids at the corners of a sole; every
/// transmissible wrench is a nonnegative sum of them.
MatrixXd corner_rays(double mu, double X, double Y) {
  MatrixXd rays(6, 16);
  int column = 0;
  for (const double x : {-X, X})
    for (const double y : {-Y, Y})
      for (const double fx : {-mu, mu})
        for (const double fy : {-mu, mu}) {
          const Vector3d p(x, y, 0), f(fx, fy, 1);
          rays.col(column++) << f, p.cross(f);
        }
  return rays;
}

TEST(WrenchCone, FacetsMatchForcesAtSoleCorners) {
  const double mu = 0.7, X = 0.11, Y = 0.06;
  const MatrixXd rays = corner_rays(mu, X, Y);
  const LinearCone cone = wrench_cone({.friction = mu}, X, Y, false);
  // All corner forces are feasible.
  for (int i = 0; i < rays.cols(); ++i) EXPECT_TRUE(inside(cone, rays.col(i)));
  // Every supporting hyperplane through five independent rays is a row.
  std::vector<int> pick{0, 1, 2, 3, 4};
  int facets = 0;
  for (bool more = true; more;) {
    MatrixXd five(5, 6);
    for (int i = 0; i < 5; ++i) five.row(i) = rays.col(pick[i]).transpose();
    const Eigen::JacobiSVD<MatrixXd> svd(five, Eigen::ComputeFullV);
    if (svd.singularValues()[4] > 1e-9) {
      VectorXd normal = svd.matrixV().col(5);
      const VectorXd sides = rays.transpose() * normal;
      const double top = sides.maxCoeff(), bottom = sides.minCoeff();
      if (top < 1e-9 || bottom > -1e-9) {
        if (bottom > -1e-9) normal = -normal;
        bool known = false;
        for (int r = 0; r < 16; ++r) {
          const VectorXd row = cone.A.row(r).transpose().normalized();
          known = known || (row - normal).norm() < 1e-9;
        }
        EXPECT_TRUE(known) << normal.transpose();
        ++facets;
      }
    }
    int i = 4;
    while (i >= 0 && pick[i] == 11 + i) --i;
    more = i >= 0;
    if (more) {
      ++pick[i];
      for (int j = i + 1; j < 5; ++j) pick[j] = pick[j - 1] + 1;
    }
  }
  EXPECT_GT(facets, 16);
}

TEST(RotationToNormal, MapsTheVerticalToTheNormal) {
  RandomNumbers random(9);
  std::vector<Vector3<double>> normals{{0, 0, 1}, {0, 0, -1}, {1, 0, 0}};
  for (int i = 0; i < 20; ++i) normals.push_back(random_normal(random));
  for (const Vector3<double>& n : normals) {
    const Matrix3<double> R = rotation_to_normal(n);
    const Vector3<double> up = R * Vector3<double>{0, 0, 1};
    const Matrix3<double> product = transpose(R) * R;
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(up[i], n[i], 1e-12);
      for (int j = 0; j < 3; ++j) EXPECT_NEAR(product(i, j), i == j, 1e-12);
    }
  }
}

}  // namespace
}  // namespace conddp
