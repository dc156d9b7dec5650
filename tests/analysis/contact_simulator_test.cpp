#include "analysis/contact/contact_simulator.hpp"

#include <cmath>
#include <limits>
#include <numbers>

#include <Eigen/Geometry>
#include <gtest/gtest.h>

#include "support/contact_plants.hpp"

namespace conddp {
namespace {

constexpr double kGravity = 9.81;

/// Takes a step and moves the start to its end.
ContactStep advance(ContactSimulator& simulator, const ContactPlant& plant, StepStart& start) {
  const ContactStep step = simulator.step(start);
  EXPECT_EQ(step.status, StepStatus::solved) << step.residual;
  const double scale = impulse_scale(plant, start.h);
  EXPECT_LT(stepping_residual(plant, start, step.v, step.forces).cwiseAbs().maxCoeff(),
            1e-9 * scale);
  start.q = step.q;
  start.v = step.v;
  return step;
}

StepStart sliding_puck(const ContactPlant& plant, double h) {
  StepStart start = at_rest(plant, h);
  start.v << 1, 2, 0;
  return start;
}

StepStart standing_block(const ContactPlant& plant, double h) {
  StepStart start = at_rest(plant, h);
  start.q[velocity_index(plant, "base_z")] = 0.5;
  return start;
}

/// A point mass sliding on a plane in space.
ContactPlant puck(FrictionModel friction) {
  const std::string text =
      R"(<robot name="puck"><link name="table"/><link name="a"/><link name="b"/>
    <link name="puck"><inertial><mass value="2"/>
      <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
    <joint name="x" type="prismatic"><parent link="table"/><child link="a"/><axis xyz="1 0 0"/>
      <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
    <joint name="y" type="prismatic"><parent link="a"/><child link="b"/><axis xyz="0 1 0"/>
      <limit lower="-9" upper="9" effort="1" velocity="1"/></joint>
    <joint name="z" type="prismatic"><parent link="b"/><child link="puck"/><axis xyz="0 0 1"/>
      <limit lower="-9" upper="9" effort="1" velocity="1"/></joint></robot>)";
  ContactPlant plant;
  plant.robot = std::make_shared<RobotModel>(*parse_urdf(text, "puck").model);
  plant.contacts.candidates = {on_ground(plant, "puck", 0.3)};
  plant.contacts.friction = friction;
  return plant;
}

TEST(ContactSimulator, BlockStaysBelowTheFrictionAngle) {
  const double angle = std::atan(0.49);
  const ContactPlant plant = block_on_slope(0.5, angle);
  ContactSimulator simulator(plant);
  StepStart start = standing_block(plant, 0.01);
  for (int k = 0; k < 50; ++k) {
    const ContactStep step = advance(simulator, plant, start);
    EXPECT_LT(step.v.cwiseAbs().maxCoeff(), 1e-12);
    EXPECT_NEAR(step.forces.contact.row(0).sum(), kGravity * std::cos(angle), 1e-9);
    EXPECT_NEAR(step.forces.contact.row(1).sum(), -kGravity * std::sin(angle), 1e-9);
  }
}

TEST(ContactSimulator, BlockSlidesAboveTheFrictionAngle) {
  const double angle = std::atan(0.6), h = 0.01;
  const ContactPlant plant = block_on_slope(0.5, angle);
  ContactSimulator simulator(plant);
  StepStart start = standing_block(plant, h);
  const double a = kGravity * (std::sin(angle) - 0.5 * std::cos(angle));
  for (int k = 1; k <= 50; ++k) {
    const ContactStep step = advance(simulator, plant, start);
    EXPECT_NEAR(step.v[0], k * h * a, 1e-10);
    EXPECT_NEAR(step.v[1], 0, 1e-12);
    EXPECT_NEAR(step.v[2], 0, 1e-12);
    for (int c = 0; c < 2; ++c)
      EXPECT_NEAR(step.forces.contact(1, c), -0.5 * step.forces.contact(0, c), 1e-9);
  }
}

TEST(ContactSimulator, CrateRestsOnItsCorners) {
  for (const FrictionModel friction : {FrictionModel::polyhedron, FrictionModel::cone}) {
    const ContactPlant plant = crate(0.5, friction);
    ContactSimulator simulator(plant);
    StepStart start = crate_start(0.1, 0, 0.01);
    for (int k = 0; k < 20; ++k) {
      const ContactStep step = advance(simulator, plant, start);
      EXPECT_LT(step.v.cwiseAbs().maxCoeff(), 1e-12);
      EXPECT_NEAR(step.forces.contact.row(0).sum(), kGravity, 1e-9);
      EXPECT_LT(step.forces.contact.bottomRows<2>().cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(ContactSimulator, SlidingCrateSlowsDownByFriction) {
  const double h = 0.01, friction = 0.3;
  const ContactPlant plant = crate(friction, FrictionModel::cone);
  ContactSimulator simulator(plant);
  StepStart start = crate_start(0.1, 0, h);
  const Eigen::Vector2d heading(0.8, 0.6);
  start.v.head(2) = heading;
  for (int k = 1; k <= 50; ++k) {
    advance(simulator, plant, start);
    const double speed = std::max(0.0, 1 - k * h * friction * kGravity);
    EXPECT_LT((start.v.head(2) - speed * heading).norm(), 1e-9) << k;
    EXPECT_LT(start.v.tail(4).norm(), 1e-9) << k;
  }
  EXPECT_LT(start.v.norm(), 1e-12);
}

/// Backward Euler in body axes without contact: M (v⁺ − v)/h = (m g, 0) − v⁺ × M v⁺.
TEST(ContactSimulator, SpinningCrateFliesByItsDefinition) {
  const double h = 0.01;
  const ContactPlant plant = crate(0.5);
  ContactSimulator simulator(plant);
  StepStart start = crate_start(3, 0.3, h);
  start.v << 1, -0.5, 2, 3, -4, 5;
  for (int k = 0; k < 30; ++k) {
    const Eigen::VectorXd before = start.v;
    advance(simulator, plant, start);
    const Eigen::Quaterniond turned(start.q[6], start.q[3], start.q[4], start.q[5]);
    const Eigen::Vector3d v = start.v.head<3>(), w = start.v.tail<3>();
    const Eigen::Vector3d rate = turned.conjugate() * Eigen::Vector3d(0, 0, -kGravity) - w.cross(v);
    EXPECT_LT((start.v.head<3>() - before.head<3>() - h * rate).norm(), 1e-12) << k;
    EXPECT_LT((w - before.tail<3>()).norm(), 1e-12) << k;  // a cube has isotropic inertia
    EXPECT_NEAR(turned.norm(), 1, 1e-13) << k;
  }
}

TEST(ContactSimulator, TiltedCrateLandsTumblesAndComesToRest) {
  const ContactPlant plant = crate(0.5, FrictionModel::cone);
  ContactSimulator simulator(plant);
  ContactMechanics<double> mechanics(plant);
  StepStart start = crate_start(0.25, 0.5, 0.01);
  start.v << 0.3, 0.2, 0, 1, 2, 0.5;
  ContactStep last{.forces = StepForces(plant.contacts)};
  for (int k = 0; k < 150; ++k) {
    last = advance(simulator, plant, start);
    for (const auto& instant : mechanics.look(start.q.data())) EXPECT_GE(instant.gap, -1e-9) << k;
  }
  EXPECT_LT(start.v.norm(), 1e-6);
  EXPECT_NEAR(start.q[2], 0.1, 1e-6);
  EXPECT_NEAR(last.forces.contact.row(0).sum(), kGravity, 1e-6);
}

TEST(ContactSimulator, FallingBlockLandsWithoutReboundOrPenetration) {
  const double h = 0.01;
  const ContactPlant plant = block_on_slope(0.5);
  ContactSimulator simulator(plant);
  StepStart start = standing_block(plant, h);
  start.q[1] += 0.2;
  bool landed = false;
  double height = 0.2;
  for (int k = 1; k <= 60; ++k) {
    const ContactStep step = advance(simulator, plant, start);
    height -= h * k * h * kGravity;
    landed = landed || height < 0;
    EXPECT_GE(step.q[1], 0.5 - 1e-12);
    if (!landed) {
      EXPECT_NEAR(step.v[1], -k * h * kGravity, 1e-10);
      EXPECT_EQ(step.forces.contact.cwiseAbs().maxCoeff(), 0);
    } else {
      EXPECT_NEAR(step.q[1], 0.5, 1e-12);
    }
  }
  EXPECT_TRUE(landed);
  EXPECT_LT(start.v.cwiseAbs().maxCoeff(), 1e-12);
}

TEST(ContactSimulator, PushedBlockSticksSlipsAndSticksAgain) {
  const double h = 0.01, grip = 0.5 * kGravity;
  const ContactPlant plant = block_on_slope(0.5);
  ContactSimulator simulator(plant);
  StepStart start = standing_block(plant, h);
  double speed = 0;
  int stopped = -1;
  for (int k = 0; k < 100; ++k) {
    // Ramp to 1.5 times the grip within half a second, then zero.
    const double push = k < 50 ? 1.5 * grip * (k + 1) / 50 : 0;
    start.applied[0] = push;
    const ContactStep step = advance(simulator, plant, start);
    speed = std::max(0.0, speed + h * (push - grip));
    EXPECT_NEAR(step.v[0], speed, 1e-10) << "step " << k;
    if (k > 50 && speed == 0 && stopped < 0) stopped = k;
  }
  EXPECT_GT(stopped, 51);
  EXPECT_LT(stopped, 90);
}

/// A force applied high up tips the block over its front corner instead of sliding it.
TEST(ContactSimulator, HighFrictionTipsTheBlock) {
  const double h = 0.001;
  const ContactPlant plant = block_on_slope(2, std::atan(1.2));
  ContactSimulator simulator(plant);
  StepStart start = standing_block(plant, h);
  for (int k = 0; k < 100; ++k) {
    const ContactStep step = advance(simulator, plant, start);
    EXPECT_EQ(step.forces.contact(0, 0), 0) << "the rear corner lifts";
    EXPECT_GT(step.forces.contact(0, 1), 0);
  }
  // Initial rotation about that corner: (1/6 + 1/2) m l² α = m g l (sin − cos)/2.
  const double angle = std::atan(1.2);
  const double slope = kGravity * (std::sin(angle) - std::cos(angle)) / 2 / (1.0 / 6 + 0.5);
  EXPECT_NEAR(start.v[2], 0.1 * slope, 0.01 * slope);
}

TEST(ContactSimulator, DuplicateContactsChangeNothing) {
  ContactPlant plant = block_on_slope(0.5, std::atan(0.6));
  const auto once = plant.contacts.candidates;
  for (int copy = 0; copy < 3; ++copy)
    plant.contacts.candidates.insert(plant.contacts.candidates.end(), once.begin(), once.end());
  ContactSimulator simulator(plant);
  StepStart start = standing_block(plant, 0.01);
  for (int k = 0; k < 20; ++k) advance(simulator, plant, start);
  const double angle = std::atan(0.6);
  EXPECT_NEAR(start.v[0], 0.2 * kGravity * (std::sin(angle) - 0.5 * std::cos(angle)), 1e-10);
}

TEST(ContactSimulator, JointStopsHoldTheAcrobotsElbow) {
  ContactPlant plant = contact_plant("acrobot", {"elbow"});
  const int elbow = plant.robot->find_joint("elbow").value();
  const double limit = std::numbers::pi / 2;
  plant.contacts.stops = {{elbow, -limit, limit}};
  ContactSimulator simulator(plant);
  StepStart start = at_rest(plant, 0.01);
  start.applied[1] = 8;
  int stopped = 0;
  for (int k = 0; k < 200; ++k) {
    const ContactStep step = advance(simulator, plant, start);
    EXPECT_LE(step.q[1], limit + 1e-11);
    EXPECT_EQ(step.forces.stop_lower[0], 0);
    if (step.forces.stop_upper[0] > 0) {
      ++stopped;
      EXPECT_NEAR(step.q[1], limit, 1e-11);
    }
  }
  EXPECT_GT(stopped, 20);
}

/// A ball stays in contact with a spring for half a period, π √(m/k). Each step is v⁺ = (v − h k
/// x/m)/(1 + h² k/m).
TEST(ContactSimulator, SoftWallIsASpring) {
  const double k = 200, h = 1e-4, m = 2;
  ContactPlant plant = puck(FrictionModel::polyhedron);
  ContactCandidate& wall = plant.contacts.candidates[0];
  wall.friction = 0;
  wall.against = ContactHalfSpace{.normal = {-1, 0, 0}, .offset = -0.1};
  wall.stiffness = k;
  ContactSimulator simulator(plant);
  StepStart start = at_rest(plant, h);
  start.v[0] = 1;
  double x = -0.1, v = 1, touched = 0;
  for (int i = 0; i < 6000; ++i) {
    const double inside = (v - h * k * x / m) / (1 + h * h * k / m);
    if (x + h * inside > 0) {
      v = inside;
      touched += h;
    }
    x += h * v;
    const ContactStep step = advance(simulator, plant, start);
    EXPECT_NEAR(step.v[0], v, 1e-9);
    EXPECT_NEAR(step.forces.contact(0, 0), k * std::max(0.0, x), 1e-6);
  }
  EXPECT_LT(v, 0) << "it has come back";
  EXPECT_NEAR(touched, std::numbers::pi * std::sqrt(m / k), 1e-3);
}

TEST(ContactSimulator, DryFrictionOfAJointStopsIt) {
  const double h = 0.01, limit = 4.905;
  ContactPlant plant = contact_plant("push_box", {"box_x"});
  plant.contacts.frictions = {{plant.robot->find_joint("box_x").value(), limit}};
  ContactSimulator simulator(plant);
  StepStart start = at_rest(plant, h);
  const int x = velocity_index(plant, "box_x");
  start.v[x] = -1;
  double speed = -1;
  for (int k = 0; k < 60; ++k) {
    start.applied[x] = k < 40 ? 0 : 0.1 * (k - 40);
    const ContactStep step = advance(simulator, plant, start);
    speed = std::min(0.0, speed + h * limit);
    EXPECT_NEAR(step.v[x], speed, 1e-10);
    if (speed < 0) {
      EXPECT_NEAR(step.forces.friction[0], limit, 1e-9);
    } else if (k >= 40) {
      EXPECT_NEAR(step.forces.friction[0], -start.applied[x], 1e-9);
    }
  }
}

TEST(ContactSimulator, NonFiniteNumbersAreAStatus) {
  const ContactPlant plant = block_on_slope(0.5);
  ContactSimulator simulator(plant);
  for (const double bad :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    StepStart start = standing_block(plant, 0.01);
    start.v[2] = bad;
    EXPECT_EQ(simulator.step(start).status, StepStatus::not_finite);
  }
  StepStart start = standing_block(plant, 0.01);
  start.v[2] = 1e200;
  const ContactStep step = simulator.step(start);
  EXPECT_NE(step.status, StepStatus::solved);
  EXPECT_TRUE(step.q.allFinite() && step.v.allFinite() && step.forces.finite());
}

TEST(ContactSimulator, ConeOpposesTheSlipInSpace) {
  const double h = 0.01;
  const ContactPlant plant = puck(FrictionModel::cone);
  ContactSimulator simulator(plant);
  StepStart start = sliding_puck(plant, h);
  const Eigen::Vector3d along = start.v.normalized();
  double speed = start.v.norm();
  for (int k = 0; k < 100; ++k) {
    const ContactStep step = advance(simulator, plant, start);
    speed = std::max(0.0, speed - h * 0.3 * kGravity);
    EXPECT_NEAR((step.v - speed * along).norm(), 0, 1e-9) << "step " << k;
    EXPECT_LE(step.forces.contact.col(0).tail<2>().norm(), 0.3 * step.forces.contact(0, 0) + 1e-8);
  }
}

/// Nearly parallel cones on feet with coupled loads and slips.
TEST(ContactSimulator, ConesOfThreeFeetOpposeBodySlip) {
  const double h = 0.02, friction = 0.3, mass = 0.5;
  ContactPlant plant = contact_plant("puck", {});
  plant.contacts.plane.reset();
  plant.contacts.friction = FrictionModel::cone;
  for (const char* foot : {"foot_1", "foot_2", "foot_3"})
    plant.contacts.candidates.push_back(on_ground(plant, foot, friction));
  ContactSimulator simulator(plant);
  for (const double heading : {0.0, 0.5404195, 2.0, -1.2}) {
    StepStart start = at_rest(plant, h);
    start.q[velocity_index(plant, "base_z")] = 0.02;
    const Eigen::Vector2d along(std::cos(heading), std::sin(heading));
    double speed = 0;
    // Pushed from rest, then released until it stops.
    for (int k = 0; k < 25; ++k) {
      const double push = k < 5 ? 6 : 0;
      start.applied.head<2>() = push * along;
      const ContactStep step = advance(simulator, plant, start);
      speed = std::max(0.0, speed + h * (push / mass - friction * kGravity));
      EXPECT_NEAR((step.v.head<2>() - speed * along).norm(), 0, 1e-9) << k;
      EXPECT_NEAR(step.v.tail<4>().norm(), 0, 1e-9) << k;
    }
    EXPECT_EQ(speed, 0);
  }
}

TEST(ContactSimulator, PyramidIsWeakerBetweenItsEdges) {
  const double h = 0.01;
  const ContactPlant plant = puck(FrictionModel::polyhedron);
  ContactSimulator simulator(plant);
  StepStart start = sliding_puck(plant, h);
  const ContactStep step = advance(simulator, plant, start);
  // All friction acts along the faster tangent.
  EXPECT_NEAR(step.v[0], 1, 1e-12);
  EXPECT_NEAR(step.v[1], 2 - h * 0.3 * kGravity, 1e-10);
}

/// Midpoint steps of the free acrobot conserve its energy; backward Euler dissipates it.
TEST(ContactSimulator, MidpointSchemeConservesEnergy) {
  for (const SteppingScheme scheme :
       {SteppingScheme::backward_euler, SteppingScheme::variational_midpoint}) {
    ContactPlant plant = contact_plant("acrobot", {});
    plant.contacts.scheme = scheme;
    ContactSimulator simulator(plant);
    StepStart start = at_rest(plant, 0.01);
    start.q << 1, 0.5;
    RobotData<double> data(*plant.robot);
    const auto energy = [&](const Eigen::VectorXd& q, const Eigen::VectorXd& v) {
      update_placements(*plant.robot, q.data(), data);
      update_velocities(*plant.robot, v.data(), data);
      update_composite_inertias(*plant.robot, data);
      return kinetic_energy(*plant.robot, data) + potential_energy(*plant.robot, data);
    };
    const double before = energy(start.q, start.v);
    double worst = 0;
    for (int k = 0; k < 500; ++k) {
      const ContactStep step = advance(simulator, plant, start);
      // The discrete velocity belongs to the midpoint.
      const Eigen::VectorXd middle = step.q - 0.005 * step.v;
      worst = std::max(worst, std::abs(energy(middle, step.v) - before));
    }
    if (scheme == SteppingScheme::variational_midpoint)
      EXPECT_LT(worst, 0.02);
    else
      EXPECT_GT(worst, 1);
  }
}

/// The position of a mass without contact affects nothing, so its equations do not see it.
TEST(ContactSimulator, ReportsUnusedNonFinitePosition) {
  ContactPlant plant = puck(FrictionModel::polyhedron);
  plant.contacts.candidates.clear();
  ContactSimulator simulator(plant);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  StepStart start = at_rest(plant, 0.01);
  EXPECT_EQ(simulator.step(start).status, StepStatus::solved);
  start.q[0] = nan;
  EXPECT_EQ(simulator.step(start).status, StepStatus::not_finite);
  start = at_rest(plant, 0.01);
  start.applied[1] = nan;
  EXPECT_EQ(simulator.step(start).status, StepStatus::not_finite);
}

/// Newton's method needs few iterations per step and reaches rounding-level residuals.
TEST(ContactSimulator, StepsReachTheLastDigitsInFewIterations) {
  struct Motion {
    ContactPlant plant;
    StepStart start;
    int iterations;  ///< at most
  };
  const ContactPlant slope = block_on_slope(0.5, std::atan(0.6));
  const ContactPlant disc = puck(FrictionModel::cone);
  for (const Motion& motion :
       {Motion{slope, standing_block(slope, 0.01), 4}, Motion{disc, sliding_puck(disc, 0.01), 6}}) {
    ContactSimulator simulator(motion.plant);
    StepStart start = motion.start;
    for (int k = 0; k < 60; ++k) {
      const ContactStep step = advance(simulator, motion.plant, start);
      EXPECT_LE(step.iterations, motion.iterations) << k;
      EXPECT_LT(step.residual, 1e-12) << k;
    }
  }
}

/// A disc whose heading turns by a third of a right angle within one step.
TEST(ContactSimulator, LargeHeadingChangesTakeFewIterationsToo) {
  const ContactPlant plant = puck(FrictionModel::cone);
  ContactSimulator simulator(plant);
  StepStart start = at_rest(plant, 0.05);
  start.v << 1, 0.2, 0;
  start.applied << 0, 20, 0;
  for (int k = 0; k < 10; ++k) {
    const ContactStep step = advance(simulator, plant, start);
    EXPECT_LE(step.iterations, 6) << k;
    EXPECT_LT(step.residual, 1e-12) << k;
    const Eigen::Vector2d force = step.forces.contact.col(0).tail<2>(), slip = step.v.head<2>();
    EXPECT_LT((force.normalized() + slip.normalized()).norm(), 1e-9) << k;
  }
}

/// Newton's method with the contact modes of the solution starts there.
TEST(ContactSimulator, KeepsAStepThatAlreadySolves) {
  ContactPlant plant = crate(0.5, FrictionModel::cone);
  ContactSimulator simulator(plant);
  StepStart start = crate_start(0.12, 0.2, 0.01);
  start.v << 0.3, 0.2, 0, 1, 2, 0.5;
  int quick = 0;
  for (int k = 0; k < 40; ++k) {
    const StepStart before = start;
    const ContactStep step = advance(simulator, plant, start);
    const ContactStep again = simulator.step(before, step);
    EXPECT_EQ(again.status, StepStatus::solved);
    EXPECT_LT((again.v - step.v).norm(), 1e-9) << k;
    quick += again.iterations <= 3;
  }
  EXPECT_GE(quick, 36) << "but for steps in which a corner lands";
}

/// A mass on a slide between two stops with dry friction, pushed against either stop.
TEST(ContactSimulator, StopsAndDryFrictionShareAPush) {
  const double h = 0.01, limit = 1.5;
  ContactPlant plant = puck(FrictionModel::polyhedron);
  plant.contacts.candidates.clear();
  const int x = plant.robot->find_joint("x").value(), y = plant.robot->find_joint("y").value(),
            z = plant.robot->find_joint("z").value();
  plant.contacts.stops = {{z, 0, kUnlimited}, {x, -0.1, 0.2}, {y, -kUnlimited, 0.3}};
  plant.contacts.frictions = {{y, 0.75}, {x, limit}};
  ContactSimulator simulator(plant);
  for (const double push : {-5.0, 7.0}) {
    StepStart start = at_rest(plant, h);
    start.q << (push < 0 ? -0.1 : 0.2), 0, 0;
    start.applied << push, 0.5, 0;
    const ContactStep step = advance(simulator, plant, start);
    EXPECT_LT(step.v.norm(), 1e-12);
    // Friction and the stop share the push: friction opposes only what the stop leaves.
    EXPECT_NEAR(step.forces.stop_lower[1] - step.forces.stop_upper[1] + step.forces.friction[1],
                -push, 1e-9);
    EXPECT_GE(push < 0 ? step.forces.stop_lower[1] : step.forces.stop_upper[1],
              std::abs(push) - limit - 1e-9);
    EXPECT_EQ(push < 0 ? step.forces.stop_upper[1] : step.forces.stop_lower[1], 0);
    EXPECT_NEAR(step.forces.friction[0], -0.5, 1e-9);
    EXPECT_NEAR(step.forces.stop_lower[0], 2 * kGravity, 1e-9);
    EXPECT_EQ(step.forces.stop_upper[2], 0);
    const ContactStep again = simulator.step(start, step);
    EXPECT_EQ(again.status, StepStatus::solved);
    EXPECT_LT(again.v.norm(), 1e-12);
  }
}

/// An unattainable tolerance makes every step try sweeps as well. The better answer wins, and both
/// agree.
TEST(ContactSimulator, SweepsAgreeWithPivotingForAllCandidates) {
  for (const FrictionModel friction : {FrictionModel::polyhedron, FrictionModel::cone}) {
    ContactPlant plant = puck(friction);
    ContactCandidate soft = plant.contacts.candidates[0];
    soft.friction = 0;
    soft.stiffness = 300;
    soft.against = ContactHalfSpace{.normal = {-1, 0, 0}, .offset = -0.3};
    plant.contacts.candidates = {soft, plant.contacts.candidates[0]};
    const int x = plant.robot->find_joint("x").value(), y = plant.robot->find_joint("y").value();
    plant.contacts.stops = {{y, -0.01, 0.02}, {x, -kUnlimited, 0.4}, {x, -0.2, kUnlimited}};
    plant.contacts.frictions = {{y, 0.25}, {x, 0.5}};
    ContactSimulator simulator(plant), strict(plant, {.tolerance = 0, .max_iterations = 15});
    StepStart start = at_rest(plant, 0.01);
    start.v << 2, 1, 0;
    int stopped = 0;
    for (int k = 0; k < 60; ++k) {
      start.applied << (k < 30 ? 15 : -15), (k % 20 < 10 ? 3 : -3), 0;
      const ContactStep other = strict.step(start);
      EXPECT_EQ(other.status, StepStatus::unsolved);
      EXPECT_LT(other.residual, 1e-10) << k;
      const ContactStep step = advance(simulator, plant, start);
      EXPECT_LT((other.v - step.v).norm(), 1e-8) << k;
      stopped += step.forces.stop_upper[0] > 0 || step.forces.stop_lower[0] > 0;
      stopped += step.forces.contact(0, 0) > 0;
    }
    EXPECT_GT(stopped, 10);
  }
}

/// One iteration solves a linear problem: a mass that stays in place.
TEST(ContactSimulator, RespectsItsIterationLimit) {
  const ContactPlant plant = puck(FrictionModel::polyhedron);
  ContactSimulator simulator(plant, {.max_iterations = 1});
  const StepStart start = at_rest(plant, 0.01);
  const ContactStep step = simulator.step(start);
  EXPECT_EQ(step.status, StepStatus::solved);
  EXPECT_EQ(step.iterations, 1);
  EXPECT_NEAR(step.forces.contact(0, 0), 2 * kGravity, 1e-9);
  ContactSimulator none(plant, {.max_iterations = 0});
  EXPECT_EQ(none.step(start).status, StepStatus::unsolved);
}

/// Two contacts under one mass: the minimum-norm forces are equal; pivoting finds others.
TEST(ContactSimulator, KnownModeSharesALoadEqually) {
  ContactPlant plant = puck(FrictionModel::polyhedron);
  plant.contacts.candidates[0].friction = 0;
  plant.contacts.candidates.push_back(plant.contacts.candidates[0]);
  ContactSimulator simulator(plant, {.max_iterations = 1});
  const StepStart start = at_rest(plant, 0.01);
  const ContactStep alone = simulator.step(start);
  ASSERT_EQ(alone.status, StepStatus::solved);
  EXPECT_GT(std::abs(alone.forces.contact(0, 0) - alone.forces.contact(0, 1)), 1);
  ContactStep near = alone;
  near.forces.contact.row(0).setConstant(1);
  const ContactStep shared = simulator.step(start, near);
  EXPECT_EQ(shared.status, StepStatus::solved);
  for (int c = 0; c < 2; ++c) EXPECT_NEAR(shared.forces.contact(0, c), kGravity, 1e-9);
}

/// Three feet carry the load and share it with their copies. The distribution is ambiguous, but
/// rotation, slip, and impact are not.
TEST(ContactSimulator, DuplicateFeetUnderTurningPuckChangeNothing) {
  ContactPlant plant = contact_plant("puck", {});
  plant.contacts.plane.reset();
  plant.contacts.friction = FrictionModel::cone;
  const auto joint = [&](const char* name) { return plant.robot->find_joint(name).value(); };
  plant.contacts.stops = {{joint("base_x"), -1, 0.015}, {joint("base_y"), -1, 1}};
  plant.contacts.frictions = {{joint("base_y"), 0.1}};
  for (const char* foot : {"foot_1", "foot_2", "foot_3"})
    plant.contacts.candidates.push_back(on_ground(plant, foot, 0.3));
  ContactPlant copied = plant;
  copied.contacts.candidates.insert(copied.contacts.candidates.end(),
                                    plant.contacts.candidates.begin(),
                                    plant.contacts.candidates.end());
  ContactSimulator simulator(plant), with_copies(copied);
  StepStart start = at_rest(plant, 0.02);
  start.q[velocity_index(plant, "base_z")] = 0.02;
  start.v[velocity_index(plant, "base_x")] = 0.5;
  start.v[velocity_index(plant, "base_y")] = 0.2;
  start.v[velocity_index(plant, "base_yaw")] = 2;
  int stopped = 0;
  for (int k = 0; k < 4; ++k) {
    const StepStart before = start;
    const ContactStep once = advance(simulator, plant, start);
    const ContactStep more = with_copies.step(before);
    EXPECT_EQ(more.status, StepStatus::solved) << k;
    EXPECT_LT((more.v - once.v).norm(), 1e-8) << k;
    EXPECT_NEAR(more.forces.contact.row(0).sum(), once.forces.contact.row(0).sum(), 1e-6) << k;
    stopped += once.forces.stop_upper[0] > 0;
  }
  EXPECT_GT(stopped, 0);
}

}  // namespace
}  // namespace conddp
