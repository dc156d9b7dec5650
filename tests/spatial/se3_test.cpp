#include "spatial/se3.hpp"

#include <gtest/gtest.h>

#include "spatial/groups.hpp"

namespace conddp {
namespace {

const Pose<double> kOrigin{Vector3<double>::zero(), Quaternion<double>::identity()};

template <class F>
void for_each_twist(F test) {
  RandomNumbers random(1);
  for (const double angle : telling_angles())
    for (const Vector3<double>& axis : directions()) {
      SCOPED_TRACE(testing::Message()
                   << "angle " << angle << " about " << axis.x << " " << axis.y << " " << axis.z);
      test(Motion<double>{random.vector(2), angle * axis});
    }
}

std::vector<Motion<double>> twist_directions() {
  std::vector<Motion<double>> all;
  for (int k = 0; k < 6; ++k) {
    Motion<double> unit = Motion<double>::zero();
    unit[k] = 1;
    all.push_back(unit);
  }
  RandomNumbers random(2);
  const Vector3<double> linear = random.vector(1);
  all.push_back({linear, random.vector(1)});
  return all;
}

Pose<double> random_pose(RandomNumbers& random) {
  const Vector3<double> p = random.vector(3);
  return {p, random.rotation()};
}

TEST(Se3, LogUndoesExp) {
  for_each_twist([](const Motion<double>& m) {
    const Pose<double> pose = integrate_se3(kOrigin, m);
    const Motion<double> back = log_se3(pose);
    // At π, rounding decides the sign of the axis; then only the pose is equal.
    if (dot(back.angular, m.angular) >= 0) {
      EXPECT_LE(largest(back - m), 1e-14);
    }
    const Pose<double> again = integrate_se3(kOrigin, back);
    EXPECT_LE(norm(again.p - pose.p), 1e-14);
    EXPECT_LE(largest(rotation_matrix(again.q) - rotation_matrix(pose.q)), 2e-15);
  });
}

TEST(Se3, DifferenceUndoesIntegration) {
  RandomNumbers random(3);
  for_each_twist([&](const Motion<double>& m) {
    if (norm(m.angular) > 3.1415) return;
    const Pose<double> a = random_pose(random);
    EXPECT_LE(largest(difference_se3(a, integrate_se3(a, m)) - m), 1e-12);
  });
}

TEST(Se3, IntegrationUndoesDifference) {
  RandomNumbers random(4);
  for (int i = 0; i < 1000; ++i) {
    const Pose<double> a = random_pose(random), b = random_pose(random);
    const Pose<double> back = integrate_se3(a, difference_se3(a, b));
    EXPECT_LE(norm(back.p - b.p), 1e-13);
    EXPECT_LE(largest(rotation_matrix(back.q) - rotation_matrix(b.q)), 1e-14);
  }
}

// A constant twist integrated by many small steps.
TEST(Se3, ExpIsTheFlowOfATwist) {
  const Motion<double> m{{0.3, -1.1, 0.6}, {1.2, 0.4, -0.9}};
  Pose<double> steps = kOrigin;
  for (int i = 0; i < 1024; ++i) steps = integrate_se3(steps, (1.0 / 1024) * m);
  EXPECT_LE(largest(log_se3(steps) - m), 1e-13);
}

TEST(Se3, RightJacobianEqualsDualNumbers) {
  for_each_twist([](const Motion<double>& m) {
    const Matrix6<double> jacobian = right_jacobian_se3(m);
    const Pose<Dual<double>> from = constant(integrate_se3(kOrigin, m));
    for (const Motion<double>& along : twist_directions()) {
      const auto moved = integrate_se3(constant(kOrigin), seeded(m, along));
      EXPECT_LE(largest(jacobian * along - slope(difference_se3(from, moved))), 1e-12);
    }
  });
}

TEST(Se3, RightJacobianEqualsFiniteDifferences) {
  const double h = 1e-5;
  for_each_twist([h](const Motion<double>& m) {
    const Matrix6<double> jacobian = right_jacobian_se3(m);
    const Pose<double> from = integrate_se3(kOrigin, m);
    for (const Motion<double>& along : twist_directions()) {
      const auto step = [&](double by) {
        return difference_se3(from, integrate_se3(kOrigin, m + by * along));
      };
      EXPECT_LE(largest(jacobian * along - (0.5 / h) * (step(h) - step(-h))), 1e-9);
    }
  });
}

TEST(Se3, InverseRightJacobianEqualsDualNumbers) {
  for_each_twist([](const Motion<double>& m) {
    const Pose<double> pose = integrate_se3(kOrigin, m);
    const Matrix6<double> inverse_jacobian = inverse_right_jacobian_se3(log_se3(pose));
    for (const Motion<double>& along : twist_directions()) {
      const auto moved = integrate_se3(constant(pose), seeded(Motion<double>::zero(), along));
      EXPECT_LE(largest(inverse_jacobian * along - slope(log_se3(moved))), 1e-12);
    }
  });
}

TEST(Se3, InverseRightJacobianIsTheInverse) {
  for_each_twist([](const Motion<double>& m) {
    const Matrix6<double> j = right_jacobian_se3(m), i = inverse_right_jacobian_se3(m);
    for (const Motion<double>& along : twist_directions())
      EXPECT_LE(largest(j * (i * along) - along), 1e-12);
  });
}

TEST(Se3, ActionsAndAdjointAgree) {
  RandomNumbers random(5);
  for (int i = 0; i < 100; ++i) {
    const SE3<double> a = random.placement(2), b = random.placement(2);
    const Motion<double> m{random.vector(1), random.vector(1)};
    const Force<double> f{random.vector(1), random.vector(1)};
    EXPECT_LE(largest(act(a, act(b, m)) - act(a * b, m)), 1e-14);
    EXPECT_LE(largest(act_inverse(a, act(a, m)) - m), 1e-14);
    EXPECT_LE(largest(act_inverse(a, m) - act(inverse(a), m)), 1e-14);
    EXPECT_LE(largest(act_inverse(a, act(a, f)) - f), 1e-14);
    EXPECT_LE(largest(adjoint(a) * m - act(a, m)), 1e-14);
    EXPECT_NEAR(dot(act(a, m), act(a, f)), dot(m, f), 1e-13);
  }
}

TEST(Se3, CrossProductsAreRatesOfActions) {
  RandomNumbers random(6);
  for (int i = 0; i < 20; ++i) {
    const Motion<double> v{random.vector(1), random.vector(1)};
    const Motion<double> m{random.vector(1), random.vector(1)};
    const Force<double> f{random.vector(1), random.vector(1)};
    const SE3<Dual<double>> moving =
        placement(integrate_se3(constant(kOrigin), seeded(Motion<double>::zero(), v)));
    const auto m_rate = act(moving, seeded(m, Motion<double>::zero()));
    EXPECT_LE(largest(slope(m_rate) - cross(v, m)), 1e-15);
    const auto f_rate = act(
        moving, Force<Dual<double>>{f.linear.cast<Dual<double>>(), f.angular.cast<Dual<double>>()});
    const Force<double> expected = cross(v, f);
    EXPECT_LE(norm(slope(f_rate.linear) - expected.linear), 1e-15);
    EXPECT_LE(norm(slope(f_rate.angular) - expected.angular), 1e-15);
    EXPECT_NEAR(dot(cross(v, m), f), -dot(m, cross(v, f)), 1e-14);
  }
}

}  // namespace
}  // namespace conddp
