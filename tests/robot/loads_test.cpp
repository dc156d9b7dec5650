// Loads whose amounts are parameters.
#include <gtest/gtest.h>

#include "robot/dynamics.hpp"
#include "robot/frames.hpp"
#include "support/random_robot.hpp"

namespace conddp {
namespace {

/// The model with the loads of a state merged into the bodies, so that parameters change nothing.
RobotModel with_fixed_loads(const RobotModel& loaded, const RobotState& state) {
  RobotModel fixed = loaded;
  fixed.loads.clear();
  for (const Load& load : loaded.loads) {
    const double amount = state.q[loaded.joints[load.parameter].q];
    const Inertia<double>& unit = load.unit;
    const Symmetric3<double>& j = unit.rotational;
    fixed.joints[load.body].inertia += Inertia<double>{
        amount * unit.mass,
        amount * unit.moment,
        {amount * j.xx, amount * j.xy, amount * j.xz, amount * j.yy, amount * j.yz, amount * j.zz}};
  }
  return fixed;
}

std::vector<RobotModel> loaded_robots() {
  std::vector<RobotModel> loaded;
  for (const TestModel& entry : random_robots())
    if (!entry.model.loads.empty()) loaded.push_back(entry.model);
  return loaded;
}

void expect_near_numbers(const AlignedVector<double>& a, const AlignedVector<double>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i)
    EXPECT_NEAR(a[i], b[i], 1e-12 * (1 + std::abs(b[i]))) << i;
}

TEST(Loads, ScaleBodyPartsByTheirAmounts) {
  RandomNumbers random(31);
  ASSERT_GE(loaded_robots().size(), 3u);
  for (const RobotModel& loaded : loaded_robots()) {
    const RobotState x = random_state(loaded, random);
    const RobotModel fixed = with_fixed_loads(loaded, x);
    RobotData<double> a(loaded), b(fixed);
    inverse_dynamics(loaded, x.q.data(), x.v.data(), x.a.data(), a);
    inverse_dynamics(fixed, x.q.data(), x.v.data(), x.a.data(), b);
    expect_near_numbers(a.tau, b.tau);
    forward_dynamics(loaded, x.q.data(), x.v.data(), x.tau.data(), a);
    forward_dynamics(fixed, x.q.data(), x.v.data(), x.tau.data(), b);
    expect_near_numbers(a.M, b.M);
    expect_near_numbers(a.bias, b.bias);
    expect_near_numbers(a.acceleration, b.acceleration);
    const Vector3<double> c = center_of_mass(loaded, a), expected = center_of_mass(fixed, b);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(c[i], expected[i], 1e-12);
  }
}

TEST(Loads, ParametersRestAndMoveNothing) {
  RandomNumbers random(32);
  for (const RobotModel& loaded : loaded_robots()) {
    RobotState x = random_state(loaded, random);
    for (const Joint& joint : loaded.joints)
      if (joint.type == JointType::parameter) x.tau[joint.v] = 0;
    RobotData<double> data(loaded);
    forward_dynamics(loaded, x.q.data(), x.v.data(), x.tau.data(), data);
    for (const Joint& joint : loaded.joints) {
      if (joint.type != JointType::parameter) continue;
      EXPECT_EQ(data.acceleration[joint.v], 0);
      for (int i = 0; i < loaded.nv; ++i)
        EXPECT_EQ(data.M[std::min(i, joint.v) * loaded.nv + std::max(i, joint.v)],
                  i == joint.v ? 1 : 0);
    }
  }
}

}  // namespace
}  // namespace conddp
