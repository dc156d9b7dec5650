#include "spatial/so3.hpp"

#include <gtest/gtest.h>

#include "spatial/groups.hpp"

namespace conddp {
namespace {

template <class F>
void for_each_rotation_vector(F test) {
  for (const double angle : telling_angles())
    for (const Vector3<double>& axis : directions()) {
      SCOPED_TRACE(testing::Message()
                   << "angle " << angle << " about " << axis.x << " " << axis.y << " " << axis.z);
      test(angle * axis);
    }
}

double distance(const Quaternion<double>& a, const Quaternion<double>& b) {
  const auto to = [&](double sign) {
    return std::max({std::abs(a.x - sign * b.x), std::abs(a.y - sign * b.y),
                     std::abs(a.z - sign * b.z), std::abs(a.w - sign * b.w)});
  };
  return std::min(to(1), to(-1));
}

TEST(So3, ExpHasUnitLength) {
  for_each_rotation_vector([](const Vector3<double>& w) {
    const Quaternion<double> q = exp_so3(w);
    EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 1e-15);
  });
}

TEST(So3, ExpTurnsAboutItsAxis) {
  const Matrix3<double> r = rotation_matrix(exp_so3(Vector3<double>{0, 0, 0.3}));
  EXPECT_NEAR(r(0, 0), std::cos(0.3), 1e-15);
  EXPECT_NEAR(r(1, 0), std::sin(0.3), 1e-15);
  EXPECT_NEAR(r(0, 1), -std::sin(0.3), 1e-15);
}

TEST(So3, LogUndoesExp) {
  for_each_rotation_vector([](const Vector3<double>& w) {
    Vector3<double> back = log_so3(exp_so3(w));
    // At π, rounding decides between w and −w, the same rotation.
    if (norm(w) > 3.14159265358 && dot(back, w) < 0) back = -back;
    EXPECT_LE(norm(back - w), 4e-16 + 1e-15 * norm(w));
  });
}

TEST(So3, LogOfSmallRotationsIsRelativelyAccurate) {
  for (const double angle : {1e-200, 1e-20, 1e-12, 1e-6, 1e-3, 1.9e-2, 2.1e-2})
    for (const Vector3<double>& axis : directions()) {
      const Vector3<double> w = angle * axis;
      EXPECT_LE(norm(log_so3(exp_so3(w)) - w), 1e-15 * angle) << angle;
    }
}

TEST(So3, ExpUndoesLog) {
  RandomNumbers random(2);
  for (int i = 0; i < 1000; ++i) {
    const Quaternion<double> q = random.rotation();
    EXPECT_LE(distance(exp_so3(log_so3(q)), q), 1e-15);
    EXPECT_LE(norm(log_so3(q)), M_PI * (1 + 1e-15));
  }
}

TEST(So3, LogOfAHalfTurnHasLengthPi) {
  for (const Vector3<double>& axis : directions())
    for (const double w : {0.0, -0.0}) {
      const Quaternion<double> q{axis.x, axis.y, axis.z, w};
      EXPECT_NEAR(norm(log_so3(q)), M_PI, 1e-15);
      EXPECT_LE(distance(exp_so3(log_so3(q)), q), 1e-15);
    }
}

TEST(So3, RightJacobianEqualsDualNumbers) {
  for_each_rotation_vector([](const Vector3<double>& w) {
    for (const Vector3<double>& along : directions()) {
      const auto moved = exp_so3(seeded(w, along));
      const Vector3<double> exact = slope(log_so3(constant(conjugate(exp_so3(w))) * moved));
      EXPECT_LE(norm(right_jacobian_so3(w) * along - exact), 1e-13);
    }
  });
}

TEST(So3, RightJacobianEqualsFiniteDifferences) {
  const double h = 1e-5;
  for_each_rotation_vector([h](const Vector3<double>& w) {
    for (const Vector3<double>& along : directions()) {
      const auto step = [&](double by) {
        return log_so3(conjugate(exp_so3(w)) * exp_so3(w + by * along));
      };
      const Vector3<double> slope = (0.5 / h) * (step(h) - step(-h));
      EXPECT_LE(norm(right_jacobian_so3(w) * along - slope), 1e-9);
    }
  });
}

TEST(So3, InverseRightJacobianEqualsDualNumbers) {
  for_each_rotation_vector([](const Vector3<double>& w) {
    const Quaternion<double> q = exp_so3(w);
    for (const Vector3<double>& along : directions()) {
      const Vector3<double> exact =
          slope(log_so3(constant(q) * exp_so3(seeded(Vector3<double>::zero(), along))));
      EXPECT_LE(norm(inverse_right_jacobian_so3(log_so3(q)) * along - exact), 1e-13);
    }
  });
}

TEST(So3, InverseRightJacobianIsTheInverse) {
  for_each_rotation_vector([](const Vector3<double>& w) {
    const Matrix3<double> product = right_jacobian_so3(w) * inverse_right_jacobian_so3(w);
    EXPECT_LE(largest(product - Matrix3<double>::identity()), 1e-14);
  });
}

TEST(So3, RenormalisationKeepsProductsAtUnitLength) {
  RandomNumbers random(3);
  Quaternion<double> q = random.rotation();
  for (int i = 0; i < 100000; ++i) q = renormalized(q * exp_so3(random.vector(0.3)));
  EXPECT_NEAR(q.x * q.x + q.y * q.y + q.z * q.z + q.w * q.w, 1, 5e-16);
}

TEST(So3, QuaternionOfAMatrixIsItsRotation) {
  RandomNumbers random(4);
  for (int i = 0; i < 1000; ++i) {
    const Quaternion<double> q = random.rotation();
    EXPECT_LE(distance(quaternion(rotation_matrix(q)), q), 1e-15);
  }
  for_each_rotation_vector([](const Vector3<double>& w) {
    EXPECT_LE(distance(quaternion(rotation_matrix(exp_so3(w))), exp_so3(w)), 1e-15);
  });
}

TEST(So3, QuaternionOfAMatrixMovesWithIt) {
  RandomNumbers random(6);
  for (int i = 0; i < 100; ++i) {
    const Quaternion<double> q = random.rotation();
    for (const Vector3<double>& along : directions()) {
      const auto moved = constant(q) * exp_so3(seeded(Vector3<double>::zero(), along));
      const auto back = quaternion(rotation_matrix(moved));
      EXPECT_LE(norm(slope(log_so3(constant(conjugate(q)) * back)) - along), 1e-14);
    }
  }
}

TEST(So3, RollPitchYawTurnsAboutFixedAxes) {
  RandomNumbers random(5);
  for (int i = 0; i < 100; ++i) {
    const Vector3<double> a = random.vector(3);
    const Quaternion<double> q = exp_so3(Vector3<double>{0, 0, a.z}) *
                                 exp_so3(Vector3<double>{0, a.y, 0}) *
                                 exp_so3(Vector3<double>{a.x, 0, 0});
    EXPECT_LE(largest(rotation_rpy(a.x, a.y, a.z) - rotation_matrix(q)), 1e-15);
  }
}

}  // namespace
}  // namespace conddp
