// Forces and energies of a plant against the robot's own functions, formulas and differences.
#include "analysis/contact/contact_mechanics.hpp"

#include <cmath>

#include <gtest/gtest.h>

#include "robot/dynamics.hpp"
#include "support/random_numbers.hpp"
#include "support/random_robot.hpp"

namespace conddp {
namespace {

std::shared_ptr<const RobotModel> random_arm() {
  return std::make_shared<const RobotModel>(
      random_robot(61, {.joints = 5, .floating = false, .wrenches = 0}));
}

TEST(ContactMechanics, LoadHasDampingAndSmoothFriction) {
  const ContactPlant bare{.robot = random_arm()};
  ContactPlant resisting = bare;
  const int n = bare.nv();
  for (int i = 0; i < n; ++i) {
    resisting.damping.push_back(0.5 + i);
    resisting.smooth_friction.push_back(i == 1 ? 0 : 2.0 + i);
  }
  resisting.friction_velocity = 0.3;
  RandomNumbers random(71);
  const std::vector<double> q = random.numbers(n, 1), v = random.numbers(n, 0.5),
                            a = random.numbers(n, 1);
  ContactMechanics<double> without(bare), with(resisting);
  const std::vector<double> less = without.load(q.data(), v.data(), a.data());
  const std::vector<double> more = with.load(q.data(), v.data(), a.data());
  RobotData<double> data(*bare.robot);
  inverse_dynamics(*bare.robot, q.data(), v.data(), a.data(), data);
  for (int i = 0; i < n; ++i) {
    EXPECT_NEAR(less[i], data.tau[i], 1e-12);
    EXPECT_NEAR(more[i] - less[i],
                (0.5 + i) * v[i] + (i == 1 ? 0 : 2.0 + i) * std::tanh(v[i] / 0.3), 1e-12)
        << "joint " << i;
  }
  EXPECT_NEAR(with.resistance(0, 1e6), 0.5e6 + 2, 1e-9);
  EXPECT_NEAR(with.resistance(0, -1e6), -0.5e6 - 2, 1e-9);
}

TEST(ContactMechanics, KineticSlopeIsThatOfTheKineticEnergy) {
  const ContactPlant plant{.robot = random_arm()};
  const int n = plant.nv();
  RandomNumbers random(72);
  const std::vector<double> q = random.numbers(n, 1), v = random.numbers(n, 1), zero(n, 0.0);
  ContactMechanics<double> mechanics(plant);
  const std::vector<double> slope = mechanics.kinetic_slope(q.data(), v.data());
  // M v is what inverse dynamics need for the acceleration v at rest, less what they need for none.
  RobotData<double> data(*plant.robot);
  const auto energy = [&](const std::vector<double>& at) {
    inverse_dynamics(*plant.robot, at.data(), zero.data(), v.data(), data);
    std::vector<double> momentum(data.tau.begin(), data.tau.end());
    inverse_dynamics(*plant.robot, at.data(), zero.data(), zero.data(), data);
    double twice = 0;
    for (int i = 0; i < n; ++i) twice += v[i] * (momentum[i] - data.tau[i]);
    return twice / 2;
  };
  constexpr double kStep = 1e-5;
  for (int i = 0; i < n; ++i) {
    std::vector<double> above = q, below = q;
    above[i] += kStep;
    below[i] -= kStep;
    EXPECT_NEAR(slope[i], (energy(above) - energy(below)) / (2 * kStep), 1e-7) << "joint " << i;
  }
}

TEST(ContactMechanics, AppliedForcesAreTheirColumnsTimesTheControls) {
  ContactPlant plant{.robot = random_arm()};
  const int n = plant.nv();
  for (int i = 0; i < 2 * n; ++i) plant.B.push_back(1 + i);
  EXPECT_EQ(plant.nu(), 2);
  const double u[] = {2, -3};
  const std::vector<double> forces = plant.applied(u);
  for (int i = 0; i < n; ++i) EXPECT_EQ(forces[i], 2 * (1 + i) - 3 * (1 + n + i));
}

}  // namespace
}  // namespace conddp
