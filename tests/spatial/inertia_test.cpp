#include "spatial/inertia.hpp"

#include <gtest/gtest.h>

#include "spatial/groups.hpp"

namespace conddp {
namespace {

Inertia<double> random_inertia(RandomNumbers& random) {
  Symmetric3<double> central = Symmetric3<double>::zero();
  for (int i = 0; i < 3; ++i) central += point_inertia(random.uniform(0.1, 1), random.vector(1));
  const Vector3<double> com = random.vector(1);
  return inertia_about_origin(random.uniform(0.5, 3), com, central);
}

Motion<double> random_motion(RandomNumbers& random) {
  const Vector3<double> linear = random.vector(1);
  return {linear, random.vector(1)};
}

Inertia<Dual<double>> constant(const Inertia<double>& i) {
  const Symmetric3<double>& j = i.rotational;
  return {i.mass, i.moment.cast<Dual<double>>(), {j.xx, j.xy, j.xz, j.yy, j.yz, j.zz}};
}

Matrix3<double> as_matrix(const Symmetric3<double>& j) {
  return {{j.xx, j.xy, j.xz, j.xy, j.yy, j.yz, j.xz, j.yz, j.zz}};
}

TEST(Inertia, ActsLikeItsParticles) {
  RandomNumbers random(1);
  for (int i = 0; i < 20; ++i) {
    const Motion<double> v = random_motion(random);
    Inertia<double> total = Inertia<double>::zero();
    Force<double> momentum = Force<double>::zero();
    for (int k = 0; k < 5; ++k) {
      const double mass = random.uniform(0.1, 2);
      const Vector3<double> c = random.vector(1);
      total += inertia_about_origin(mass, c, Symmetric3<double>::zero());
      const Vector3<double> p = mass * (v.linear + cross(v.angular, c));
      momentum += Force<double>{p, cross(c, p)};
    }
    EXPECT_LE(largest(total * v - momentum), 1e-14);
  }
}

TEST(Inertia, TransformsWithMotionsAndMomenta) {
  RandomNumbers random(2);
  for (int i = 0; i < 100; ++i) {
    const SE3<double> a = random.placement(2);
    const Inertia<double> y = random_inertia(random);
    const Motion<double> v = random_motion(random);
    EXPECT_LE(largest(act(a, y) * act(a, v) - act(a, y * v)), 1e-13);
    EXPECT_NEAR(act(a, y).mass, y.mass, 0);
  }
}

TEST(Inertia, KineticEnergyDoesNotDependOnTheFrame) {
  RandomNumbers random(3);
  for (int i = 0; i < 100; ++i) {
    const SE3<double> a = random.placement(2);
    const Inertia<double> y = random_inertia(random);
    const Motion<double> v = random_motion(random);
    EXPECT_NEAR(dot(act(a, v), act(a, y) * act(a, v)), dot(v, y * v), 1e-12);
  }
}

TEST(Inertia, RotatesLikeAMatrix) {
  RandomNumbers random(4);
  for (int i = 0; i < 100; ++i) {
    const Matrix3<double> r = rotation_matrix(random.rotation());
    const Symmetric3<double> j = random_inertia(random).rotational;
    EXPECT_LE(largest(as_matrix(rotate(r, j)) - r * as_matrix(j) * transpose(r)), 1e-14);
  }
}

TEST(Inertia, RotationalRateMatchesATwistingBody) {
  RandomNumbers random(5);
  for (int i = 0; i < 100; ++i) {
    const Inertia<double> y = random_inertia(random);
    const Motion<double> v = random_motion(random);
    const Pose<Dual<double>> origin{Vector3<Dual<double>>::zero(),
                                    Quaternion<Dual<double>>::identity()};
    const SE3<Dual<double>> moving =
        placement(integrate_se3(origin, seeded(Motion<double>::zero(), v)));
    const Symmetric3<Dual<double>> j = act(moving, constant(y)).rotational;
    const Symmetric3<double> exact{j.xx.d, j.xy.d, j.xz.d, j.yy.d, j.yz.d, j.zz.d};
    EXPECT_LE(largest(as_matrix(rotational_inertia_rate(y, v)) - as_matrix(exact)), 1e-14);
  }
}

}  // namespace
}  // namespace conddp
