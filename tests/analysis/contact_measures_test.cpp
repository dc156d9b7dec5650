// Hand-computed figures for two steps of a block on slides. It lands on the ground, a stop acts
// along x, dry friction along y, and damping along all axes.
#include <cmath>

#include <gtest/gtest.h>

#include "analysis/contact/contact_certificate.hpp"
#include "support/block_on_slides.hpp"

namespace conddp {
namespace {

constexpr double kAllWeight = 4 * 9.81;

ContactMotion two_steps(FrictionModel friction = FrictionModel::cone) {
  ContactMotion motion;
  motion.plant.robot = testing::block_on_slides();
  const RobotModel& robot = *motion.plant.robot;
  motion.plant.B = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  motion.plant.damping = {2, 2, 2};
  ImplicitContacts& contacts = motion.plant.contacts;
  contacts.candidates = {{.name = "ball",
                          .sphere = {.frame = *robot.find_frame("block"), .radius = 0.1},
                          .against = ContactHalfSpace{},
                          .friction = 0.5}};
  contacts.stops = {{*robot.find_joint("x"), -0.35, 0.3}};
  contacts.frictions = {{*robot.find_joint("y"), 1}};
  contacts.friction = friction;
  motion.first_knot = 1;
  motion.h = {0.1, 0.1};
  motion.q = {Eigen::Vector3d(0.1, 0, 0.15), Eigen::Vector3d(0.2, 0.01, 0.12),
              Eigen::Vector3d(0.2, 0.01, 0.05)};
  motion.v = {Eigen::Vector3d(0.8, 0, -0.2), Eigen::Vector3d(1, 0.1, -0.3),
              Eigen::Vector3d(0, 0, -0.7)};
  motion.u = {Eigen::Vector3d(5, 1, 2), Eigen::Vector3d(0, 0, 0)};
  StepForces first(contacts), second(contacts);
  first.contact.setZero();
  second.contact.setZero();
  first.stop_lower.setZero();
  second.stop_lower.setZero();
  second.stop_upper.setZero();
  second.friction.setZero();
  first.contact(0, 0) = 3;
  first.stop_upper[0] = 0.5;
  first.friction[0] = -0.4;
  second.contact(0, 0) = -1;
  motion.forces = {first, second};
  return motion;
}

TEST(ContactMeasures, PairMeasuresUseForcesAndGaps) {
  const ContactMeasures found = measure_contacts(two_steps());
  // Ball: 3 N at 2 cm, then −1 N at −5 cm; stop: 0.5 N at 10 cm.
  EXPECT_NEAR(found.complementarity.value, 1, 1e-12);
  EXPECT_EQ(found.complementarity.knot, 2);
  EXPECT_NEAR(found.product.value, 0.06, 1e-12);
  EXPECT_EQ(found.product.what, "ball");
  EXPECT_EQ(found.product.knot, 1);
  EXPECT_NEAR(found.distant.value, 0.1, 1e-12);
  EXPECT_EQ(found.distant.what, "stop of x");
  EXPECT_NEAR(found.signs.value, 1 / kAllWeight, 1e-12);
  EXPECT_EQ(found.signs.what, "ball");
  EXPECT_EQ(found.signs.knot, 2);
  EXPECT_NEAR(found.penetration.value, 0.05, 1e-12);
  EXPECT_EQ(found.penetration.knot, 2);
  // Nine tenths of the way from 2 cm above to 5 cm below the surface.
  EXPECT_NEAR(found.between.value, 0.043, 1e-12);
  EXPECT_EQ(found.between.what, "ball");
}

TEST(ContactMeasures, FrictionMeasuresIncludeDryFriction) {
  ContactMotion motion = two_steps();
  const ContactMeasures found = measure_contacts(motion);
  // The ball slides at (1, 0.1) m/s without friction, although 1.5 N are available.
  EXPECT_NEAR(found.friction.value, 1, 1e-12);
  EXPECT_NEAR(found.slip.value, std::hypot(1, 0.1), 1e-12);
  EXPECT_NEAR(found.dissipation.value, 1.5 * std::hypot(1, 0.1) / kAllWeight, 1e-12);
  EXPECT_EQ(found.dissipation.what, "ball");
  // In the second step 1 N pulls; the friction limit of −0.5 N is violated even without friction.
  EXPECT_NEAR(found.cone.value, 0.5 / kAllWeight, 1e-12);
  EXPECT_EQ(found.cone.knot, 2);
  // Full friction against the motion satisfies the friction law.
  const Eigen::Vector2d along = Eigen::Vector2d(1, 0.1).normalized();
  motion.forces[0].contact.col(0).tail<2>() = -1.5 * along;
  const ContactMeasures better = measure_contacts(motion);
  EXPECT_EQ(better.slip.what, "friction of y");
  EXPECT_NEAR(better.slip.value, 0.1, 1e-12);
  EXPECT_NEAR(better.dissipation.value, (1 * 0.1 - 0.4 * 0.1) / kAllWeight, 1e-12);
}

TEST(ContactMeasures, PyramidMeasuresUseTheirTangents) {
  const ContactMeasures found = measure_contacts(two_steps(FrictionModel::polyhedron));
  EXPECT_NEAR(found.slip.value, 1, 1e-12);
  EXPECT_NEAR(found.dissipation.value, 1.5 * 1 / kAllWeight, 1e-12);
}

TEST(ContactMeasures, WorkIsForceTimesDistance) {
  const ContactMeasures found = measure_contacts(two_steps());
  // From 2 cm above to 5 cm below, −1 N does 0.07 J of work; stop and friction oppose the motion.
  EXPECT_NEAR(found.work.value, 0.07, 1e-12);
  EXPECT_EQ(found.work.what, "ball");
  EXPECT_NEAR(found.work_contacts, 3 * -0.03 + 0.07 - 0.5 * 0.1 - 0.1 * 0.4 * 0.1, 1e-12);
  EXPECT_NEAR(found.work_controls, 0.1 * (5 * 1 + 1 * 0.1 - 2 * 0.3), 1e-12);
  EXPECT_NEAR(found.work_damping, -0.1 * 2 * (1 + 0.01 + 0.09 + 0.49), 1e-12);
  EXPECT_NEAR(found.energy_start, 0.5 * (4 * 0.64 + 2 * 0.04) + 2 * 9.81 * 0.15, 1e-12);
  EXPECT_NEAR(found.energy_end, 0.5 * 2 * 0.49 + 2 * 9.81 * 0.05, 1e-12);
  EXPECT_NEAR(found.stepping_loss(),
              found.energy_start + found.work_controls + found.work_contacts + found.work_damping -
                  found.energy_end,
              1e-12);
}

TEST(ContactMeasures, SteppingIsTheMissingForceInTheEquations) {
  ContactMotion motion = two_steps();
  motion.h.pop_back();
  const ContactMeasures found = measure_contacts(motion);
  // Along z: 2 kg · (−1 m/s²) + 19.62 N against 2 N of control, 3 N from the ball, and 0.6 N of
  // damping.
  EXPECT_NEAR(found.stepping.value, (2 * -1 + 19.62 - 2 - 3 - 0.6) / kAllWeight, 1e-12);
  EXPECT_EQ(found.stepping.what, "z");
  EXPECT_EQ(found.stepping.knot, 1);
  // Along x: 4 kg · 2 m/s² against 5 N of control, −0.5 N from the stop, and −2 N of damping; z is
  // balanced.
  motion.u[0][2] += 2 * -1 + 19.62 - 2 - 3 - 0.6;
  const ContactMeasures along_x = measure_contacts(motion);
  EXPECT_NEAR(along_x.stepping.value, (4 * 2 - 5 + 0.5 + 2) / kAllWeight, 1e-12);
  EXPECT_EQ(along_x.stepping.what, "x");
}

TEST(WorstFigure, KeepsTheFirstMaximum) {
  WorstFigure figure;
  figure.meet(0, 1, "none");
  EXPECT_EQ(figure.knot, -1);
  figure.meet(2, 3, "first");
  figure.meet(2, 4, "as large");
  EXPECT_EQ(figure.what, "first");
  figure.meet(std::nan(""), 5, "none");
  figure.meet(7, 6, "later");
  EXPECT_TRUE(std::isnan(figure.value));
}

}  // namespace
}  // namespace conddp
