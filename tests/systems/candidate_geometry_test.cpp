// Geometry of contact candidates: known figures, and derivatives compared with differences.
#include "systems/contact/candidate_geometry.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "robot/kinematics.hpp"
#include "support/candidate_cases.hpp"
#include "support/random_robot.hpp"
#include "systems/state_manifold.hpp"

namespace conddp {
namespace {

CandidateRows<double> rows_at(const RobotModel& model, const CandidateGeometry& geometry,
                              const std::vector<double>& q, bool slopes = false) {
  RobotData<double> data(model);
  update_placements(model, q.data(), data);
  auto out = geometry.create_rows<double>();
  if (slopes)
    geometry.differentiate(data, out);
  else
    geometry.evaluate(data, out);
  return out;
}

/// q moved by h along a tangent direction.
std::vector<double> moved(const RobotModel& model, const std::vector<double>& q, int direction,
                          double h) {
  StateManifold space;
  for (const Joint& joint : model.joints)
    joint.type == JointType::floating ? space.append(StateManifold::Part::se3)
                                      : space.append(StateManifold::Part::flat, 1);
  std::vector<double> off(model.nv, 0.0), out(model.nq);
  off[direction] = h;
  space.integrate(q.data(), off.data(), out.data());
  return out;
}

class CandidateDerivatives : public ::testing::TestWithParam<bool> {};
INSTANTIATE_TEST_SUITE_P(Bases, CandidateDerivatives, ::testing::Bool(),
                         [](const auto& test) { return test.param ? "floating" : "bolted"; });

TEST_P(CandidateDerivatives, AgreeWithDifferences) {
  const RobotModel model = random_robot(7, {.joints = 6, .floating = GetParam(), .branching = 0.6});
  RandomNumbers random(3);
  const std::vector<double> q = random_state(model, random).q;
  const double h = 1e-6;
  for (const CandidateCase& c : candidate_cases(model)) {
    SCOPED_TRACE(c.name);
    const CandidateGeometry geometry(model, c.candidate, c.plane);
    const int k = static_cast<int>(geometry.columns().size());
    const int n = 1 + geometry.tangents();
    ASSERT_GT(k, 0);
    const CandidateRows<double> at = rows_at(model, geometry, q, true);
    double largest = 0;
    for (int i = 0; i < k; ++i) {
      const auto beside = [&](double off) {
        return rows_at(model, geometry, moved(model, q, geometry.columns()[i], off));
      };
      const auto above = beside(h), below = beside(-h);
      EXPECT_NEAR(at.rows[i], (above.gap - below.gap) / (2 * h), 1e-7) << "gap, column " << i;
      for (int e = 0; e < n * k; ++e) {
        EXPECT_NEAR(at.slopes[i * n * k + e], (above.rows[e] - below.rows[e]) / (2 * h), 1e-7)
            << "row " << e / k << ", column " << e % k << " by " << i;
        largest = std::max(largest, std::abs(at.slopes[i * n * k + e]));
      }
    }
    EXPECT_GT(largest, 1e-3);
    for (int r = 0; r < n; ++r) {
      EXPECT_NEAR(squared_norm(at.directions[r]), 1, 1e-12);
      for (int s = 0; s < r; ++s) EXPECT_NEAR(dot(at.directions[r], at.directions[s]), 0, 1e-12);
    }
  }
}

TEST(CandidateGeometry, KnownGaps) {
  const RobotModel model = random_robot(7, {.joints = 2});
  const auto gap = [&](const ContactSphere& sphere, auto against) {
    const CandidateGeometry geometry(model, {"pair", sphere, against, 0.5, {}}, {});
    return rows_at(model, geometry, {0, 0});
  };
  const ContactSphere ball{-1, {3, 0, 4}, 0.5};
  EXPECT_DOUBLE_EQ(gap(ball, ContactHalfSpace{-1, {0, 0, 1}, 1}).gap, 2.5);
  EXPECT_DOUBLE_EQ(gap(ball, ContactSphere{-1, {0, 0, 0}, 1}).gap, 3.5);
  const ContactBox box{-1, SE3<double>::identity(), {1, 1, 1}};
  EXPECT_DOUBLE_EQ(gap(ball, box).gap, std::sqrt(4 + 9) - 0.5);
  // Inside, the nearest face counts.
  const auto inside = gap({-1, {0.2, 0, -0.7}, 0}, box);
  EXPECT_NEAR(inside.gap, -0.3, 1e-15);
  EXPECT_DOUBLE_EQ(inside.directions[0].z, -1);
}

/// The rows of a floating body are the velocity of its corner.
TEST(CandidateGeometry, FloatingBodyRowsMatchPointVelocities) {
  const RobotModel model = random_robot(7, {.joints = 1, .floating = true});
  int base = 0;
  for (int i = 0; i < static_cast<int>(model.frames.size()); ++i)
    if (model.frames[i].joint == 0) base = i;
  const SE3<double>& frame = model.frames[base].placement;
  const CandidateGeometry geometry(
      model, {"toe", {base, {0.1, 0.2, 0.3}, 0}, ContactHalfSpace{-1, {0, 0, 1}, 0.4}, 0.5, {}},
      {});
  EXPECT_EQ(geometry.columns(), (std::vector<int>{0, 1, 2, 3, 4, 5}));
  RandomNumbers random(3);
  const RobotState state = random_state(model, random);
  const auto at = rows_at(model, geometry, state.q);
  const Matrix3<double> R =
      rotation_matrix(Quaternion<double>{state.q[3], state.q[4], state.q[5], state.q[6]});
  const Vector3<double> arm = frame.p + frame.R * Vector3<double>{0.1, 0.2, 0.3};
  EXPECT_NEAR(at.gap, state.q[2] + (R * arm).z - 0.4, 1e-12);
  const Vector3<double> linear{state.v[0], state.v[1], state.v[2]},
      angular{state.v[3], state.v[4], state.v[5]};
  const Vector3<double> velocity = R * (linear + cross(angular, arm));
  for (int r = 0; r < 3; ++r) {
    double speed = 0;
    for (int i = 0; i < 6; ++i) speed += at.rows[r * 6 + i] * state.v[i];
    EXPECT_NEAR(speed, dot(at.directions[r], velocity), 1e-12) << r;
  }
}

}  // namespace
}  // namespace conddp
