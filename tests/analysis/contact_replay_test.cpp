// Replays of a block on slides without contact: backward Euler with constant forces by hand.
#include <cmath>

#include <gtest/gtest.h>

#include "analysis/contact/contact_certificate.hpp"
#include "support/block_on_slides.hpp"

namespace conddp {
namespace {

/// Two steps of 0.1 s after a knot that chooses the initial state. The plan is 0.02 m/s too fast
/// along y at node 1 and 0.03 m too far along x at node 2.
ContactMotion planned_slide() {
  ContactMotion motion;
  motion.plant.robot = testing::block_on_slides();
  motion.plant.B = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  motion.first_knot = 1;
  motion.h = {0.1, 0.1};
  motion.u = {Eigen::Vector3d(4, 3, 21.62), Eigen::Vector3d(0, 0, 19.62)};
  motion.u_lower = Eigen::Vector3d(-5, -5, -50);
  motion.u_upper = Eigen::Vector3d(5, 6, 50);
  motion.v = {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(1.1, 0.12, 0.1),
              Eigen::Vector3d(1.1, 0.1, 0.1)};
  motion.q = {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(0.11, 0.01, 0.01),
              Eigen::Vector3d(0.25, 0.02, 0.02)};
  motion.forces.assign(2, StepForces(motion.plant.contacts));
  return motion;
}

/// Gains by knot. The first knot has invalid gains; the seventh column belongs to the chosen state.
std::vector<Eigen::MatrixXd> gains_of_knots() {
  std::vector<Eigen::MatrixXd> gains(3, Eigen::MatrixXd::Zero(3, 7));
  gains[0].setConstant(std::nan(""));
  gains[1].setConstant(7);  // no deviation at the start
  gains[2](0, 0) = -100;
  gains[2](1, 4) = -1000;
  gains[2].col(6).setConstant(std::nan(""));
  return gains;
}

TEST(ContactReplay, EachStepBeginsAtThePlan) {
  const ContactReplay replay = replay_contacts(planned_slide(), {}, 2);
  EXPECT_EQ(replay.substeps, 2);
  EXPECT_NEAR(replay.each_step.deviation, 0.03, 1e-12);
  EXPECT_EQ(replay.each_step.knot, 3);
  EXPECT_EQ(replay.each_step.entry, 0);
  EXPECT_NEAR(replay.each_step.final_state, 0.03, 1e-12);
  EXPECT_NEAR(replay.each_step.relative, 0.02 / 0.12, 1e-12);
  EXPECT_EQ(replay.each_step.lost_at, -1);
  EXPECT_EQ(replay.ambiguous_steps, 0);
  // With two half steps, the first step moves 0.0025 m less along each axis, compared with 0.02 m
  // along y and z.
  EXPECT_NEAR(replay.each_step_fine.deviation, 0.03, 1e-12);
  EXPECT_NEAR(replay.each_step_fine.relative, 0.02 / 0.12, 1e-12);
}

TEST(ContactReplay, ControlsAloneContinueFromSimulatedState) {
  ContactMotion motion = planned_slide();
  motion.q[2][0] = 0.22;
  const ContactReplay replay = replay_contacts(motion, {}, 2);
  EXPECT_NEAR(replay.controls.deviation, 0.02, 1e-12);
  EXPECT_EQ(replay.controls.knot, 2);
  EXPECT_EQ(replay.controls.entry, 4);
  EXPECT_NEAR(replay.controls.final_state, 0, 1e-12);
  EXPECT_NEAR(replay.controls_fine.deviation, 0.02, 1e-12);
  EXPECT_NEAR(replay.controls_fine.final_state, 0.0025, 1e-12);
  // In step-by-step replay, the second step starts from the planned state.
  EXPECT_NEAR(replay.each_step.final_state, 0.02, 1e-12);
}

TEST(ContactReplay, FeedbackMovesControlsWithinBounds) {
  const ContactMotion motion = planned_slide();
  const ContactReplay replay = replay_contacts(motion, gains_of_knots(), 2);
  ASSERT_TRUE(replay.feedback_fine);
  // 0.25 N along x from −0.0025 m; 20 N along y from −0.02 m/s, limited to 6 N.
  EXPECT_EQ(replay.feedback_fine->saturated, 1);
  EXPECT_NEAR(replay.feedback_fine->deviation, 0.2, 1e-12);
  EXPECT_EQ(replay.feedback_fine->knot, 3);
  EXPECT_EQ(replay.feedback_fine->entry, 4);
  EXPECT_NEAR(replay.feedback_fine->final_state, 0.2, 1e-12);
  EXPECT_NEAR(replay.feedback_fine->relative, 0.2 / 0.12, 1e-12);
  // With a wider bound along y and a plan that ends at the simulated x: 0.1075 m plus two halves.
  ContactMotion moved = motion;
  moved.u[1][1] = 20;
  moved.u_upper[1] = 50;
  moved.v[2][1] = 0.1 + 0.1 * 40 / 3;
  moved.q[2] = Eigen::Vector3d(0.2175 + 0.05 * (0.05 + 0.1) * 0.25 / 4,
                               0.0175 + 0.05 * (0.05 + 0.1) * 40 / 3, 0.0175);
  moved.v[2][0] = 1.1 + 0.1 * 0.25 / 4;
  const ContactReplay exact = replay_contacts(moved, gains_of_knots(), 2);
  EXPECT_EQ(exact.feedback_fine->saturated, 0);
  EXPECT_NEAR(exact.feedback_fine->final_state, 0, 1e-12);
}

TEST(ContactReplay, NeedsGainsOfAllKnotsForFeedback) {
  const ContactMotion motion = planned_slide();
  EXPECT_FALSE(replay_contacts(motion, {}).feedback_fine);
  EXPECT_FALSE(replay_contacts(motion, std::vector<Eigen::MatrixXd>(3, Eigen::MatrixXd::Zero(3, 7)))
                   .feedback_fine);
  std::vector<Eigen::MatrixXd> gains = gains_of_knots();
  gains.pop_back();
  EXPECT_FALSE(replay_contacts(motion, gains).feedback_fine);
}

TEST(ContactReplay, ReportsWhereTheMotionIsLost) {
  ContactMotion motion = planned_slide();
  motion.u[1][2] = std::nan("");
  const ContactReplay replay = replay_contacts(motion, {}, 2);
  EXPECT_EQ(replay.each_step.lost_at, 2);
  EXPECT_EQ(replay.controls.lost_at, 2);
  EXPECT_EQ(replay.controls_fine.lost_at, 2);
  EXPECT_EQ(replay.ambiguous_steps, 0);
}

}  // namespace
}  // namespace conddp
