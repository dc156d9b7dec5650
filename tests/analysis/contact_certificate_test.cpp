// A simulated motion passes all checks; changing one quantity makes the corresponding check fail.
#include "analysis/contact/contact_certificate.hpp"

#include <cmath>
#include <limits>

#include <gtest/gtest.h>

#include "support/thrown_block.hpp"

namespace conddp {
namespace {

std::vector<Check> judge(const ContactMotion& motion) {
  return contact_checks(motion, measure_contacts(motion), {},
                        [](int, const std::string& what) { return what; });
}

std::string failures(const ContactMotion& motion) {
  std::string names;
  for (const Check& check : judge(motion))
    if (!check.holds) names += "[" + check.name + "]";
  return names;
}

/// First step in which the lower front corner carries a load.
int carrying(const ContactMotion& motion) {
  for (int k = 0; k < motion.steps(); ++k)
    if (motion.forces[k].contact(0, 1) > 1) return k;
  return -1;
}

TEST(ContactCertificate, HoldsForASimulatedMotion) {
  const ContactMotion motion = thrown_block();
  EXPECT_EQ(failures(motion), "");
  const ContactMeasures measures = measure_contacts(motion);
  EXPECT_LT(measures.stepping.value, 1e-11);
  EXPECT_LT(measures.complementarity.value, 1e-11);
  EXPECT_LT(measures.work.value, 1e-11);
  EXPECT_GT(motion.forces[carrying(motion)].contact(0, 1), 1);
}

/// Friction dissipates the block's energy except the potential energy at its final height.
TEST(ContactCertificate, EnergyBalances) {
  const ContactMotion motion = thrown_block();
  const ContactMeasures measures = measure_contacts(motion);
  EXPECT_NEAR(measures.energy_start, 2 + 9.81 * 0.6, 1e-9);
  EXPECT_NEAR(measures.energy_end, 9.81 * 0.5, 1e-9);
  EXPECT_LT(measures.work_contacts, -0.3);
  // Backward Euler at landing and stopping dissipates half m times the square of each velocity
  // jump.
  double jumps = 0;
  for (int k = 0; k < motion.steps(); ++k)
    jumps += 0.5 * (motion.v[k + 1] - motion.v[k]).squaredNorm();
  EXPECT_NEAR(measures.stepping_loss(), jumps, 1e-9);
}

TEST(ContactCertificate, ChangedForce) {
  ContactMotion motion = thrown_block();
  motion.forces[carrying(motion)].contact(0, 1) += 1e-4;
  EXPECT_NE(failures(motion).find("[contact stepping]"), std::string::npos) << failures(motion);
}

TEST(ContactCertificate, ForceAtADistance) {
  ContactMotion motion = thrown_block();
  motion.forces[0].contact(0, 2) = 1e-3;
  EXPECT_NE(failures(motion).find("[force at a distance]"), std::string::npos) << failures(motion);
  EXPECT_NE(failures(motion).find("[contact complementarity]"), std::string::npos);
}

TEST(ContactCertificate, Penetration) {
  ContactMotion motion = thrown_block();
  for (int k = carrying(motion) + 1; k <= motion.steps(); ++k) motion.q[k][1] -= 2e-6;
  EXPECT_NE(failures(motion).find("[contact penetration]"), std::string::npos) << failures(motion);
  EXPECT_EQ(failures(motion).find("[contact stepping]"), std::string::npos)
      << "all else is as before";
}

TEST(ContactCertificate, PullingForce) {
  ContactMotion motion = thrown_block();
  const int k = carrying(motion);
  // Both corners together carry the same load.
  const double much = motion.forces[k].contact(0, 0) + motion.forces[k].contact(0, 1) + 1;
  motion.forces[k].contact(0, 0) = -1;
  motion.forces[k].contact(0, 1) = much;
  EXPECT_NE(failures(motion).find("[contact pull]"), std::string::npos) << failures(motion);
}

TEST(ContactCertificate, SignOfFriction) {
  ContactMotion motion = thrown_block();
  motion.forces[carrying(motion)].contact.row(1) *= -1;
  const std::string names = failures(motion);
  EXPECT_NE(names.find("[contact friction]"), std::string::npos) << names;
  EXPECT_NE(names.find("[contact dissipation]"), std::string::npos) << names;
  EXPECT_EQ(names.find("[contact friction cone]"), std::string::npos) << names;
}

TEST(ContactCertificate, FrictionBeyondItsCone) {
  ContactMotion motion = thrown_block();
  motion.forces[carrying(motion)].contact(1, 1) *= 1.001;
  EXPECT_NE(failures(motion).find("[contact friction cone]"), std::string::npos)
      << failures(motion);
}

TEST(ContactCertificate, StopsAndDryFriction) {
  ContactMotion motion = thrown_block();
  motion.forces[1].stop_upper[0] = 0.1;
  EXPECT_NE(failures(motion).find("[force at a distance]"), std::string::npos) << failures(motion);
  motion = thrown_block();
  motion.forces[1].friction[0] = 0.1;
  EXPECT_NE(failures(motion).find("[contact friction]"), std::string::npos) << failures(motion);
}

// A plant of 1 kg: figures at their tolerances pass, larger figures fail.
TEST(ContactCertificate, FiguresHoldUpToTheirTolerance) {
  const ContactMotion motion = thrown_block();
  const SolverOptions::Tolerances tight{.gap = 0, .constraint = 0},
      loose{.gap = 1e-6, .constraint = 2e-5};
  const double weight = impulse_scale(motion.plant, 1), slack = 2e-5;
  const struct {
    WorstFigure ContactMeasures::*figure;
    const char* name;
    double tight, loose;
  } figures[] = {
      {&ContactMeasures::stepping, "contact stepping", 1e-8, (slack + 1e-6 / 0.01) / weight},
      {&ContactMeasures::complementarity, "contact complementarity", 1e-6, slack},
      {&ContactMeasures::penetration, "contact penetration", 1e-6, slack},
      {&ContactMeasures::signs, "contact pull", 1e-6, slack},
      {&ContactMeasures::friction, "contact friction", 1e-6, slack},
      {&ContactMeasures::cone, "contact friction cone", 1e-6, slack},
      {&ContactMeasures::dissipation, "contact dissipation", 2e-6, 2 * slack},
      {&ContactMeasures::distant, "force at a distance", 1e-4, 1e-4}};
  for (const auto& [figure, name, least, more] : figures)
    for (const bool is_loose : {false, true}) {
      const double tolerance = is_loose ? more : least;
      const auto judged = [&](double value) {
        ContactMeasures measures;
        (measures.*figure).meet(value, 7, "ball");
        for (const Check& check : contact_checks(motion, measures, is_loose ? loose : tight,
                                                 [](int knot, const std::string&what) {
                                                   return what + " at " + std::to_string(knot);
                                                 })) {
          if (check.name != name) {
            EXPECT_TRUE(check.holds) << check.name;
            continue;
          }
          EXPECT_EQ(check.found, value);
          EXPECT_NEAR(check.tolerance, tolerance, 1e-12 * tolerance) << name;
          EXPECT_EQ(check.place, check.holds ? "" : "ball at 7");
          return check.holds;
        }
        ADD_FAILURE() << "there is no check " << name;
        return false;
      };
      EXPECT_TRUE(judged(tolerance * (1 - 1e-12))) << name;
      EXPECT_FALSE(judged(tolerance * (1 + 1e-12))) << name;
    }
  // Exact to the bit where the tolerance is a literal.
  ContactMeasures exact;
  exact.distant.meet(1e-4, 7, "ball");
  exact.penetration.meet(1e-6, 7, "ball");
  for (const Check& check : contact_checks(motion, exact, tight, {})) EXPECT_TRUE(check.holds);
}

TEST(ContactCertificate, MissingNumbersFail) {
  ContactMotion motion = thrown_block();
  motion.forces[3].contact(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(failures(motion).find("[contact stepping]"), std::string::npos) << failures(motion);
}

TEST(ContactReplay, FollowsASimulatedMotion) {
  const ContactMotion motion = thrown_block();
  const ContactReplay replay = replay_contacts(motion, {});
  EXPECT_LT(replay.each_step.deviation, 1e-10);
  EXPECT_LT(replay.controls.deviation, 1e-10);
  EXPECT_EQ(replay.controls.lost_at, -1);
  EXPECT_FALSE(replay.feedback_fine);
  // A ten times finer grid changes the time of landing but not the resting place.
  EXPECT_GT(replay.controls_fine.deviation, 1e-4);
  EXPECT_LT(replay.controls_fine.final_state, 0.02);
}

/// The block's center flies past the corner of a box. Without the box, the step would end inside
/// it, so either the top or the side face can stop it. Meanwhile, a corner of the block flies over
/// frictional ground without touching it.
ContactMotion past_a_corner(bool above) {
  ContactMotion motion;
  motion.plant = contact_plant("block", {"base_x"});
  ContactCandidate middle = on_ground(motion.plant, "body", 0);
  middle.against = ContactBox{
      .placement = SE3<double>{Matrix3<double>::identity(), Vector3<double>{0.5, 0, 0.5}}};
  ContactCandidate corner = on_ground(motion.plant, "corner_3", 0.5);
  corner.against = ContactHalfSpace{.offset = -5};
  motion.plant.contacts.candidates = {middle, corner};
  motion.h = {0.1};
  motion.u = {Eigen::VectorXd::Zero(1)};
  motion.u_lower = Eigen::VectorXd::Constant(1, -1);
  motion.u_upper = Eigen::VectorXd::Constant(1, 1);
  motion.q = {Eigen::Vector3d(-0.05, 1.05, 0),
              above ? Eigen::Vector3d(0.05, 1, 0) : Eigen::Vector3d(0, 0.95, 0)};
  motion.v = {Eigen::Vector3d(1, -1 + 0.981, 0),
              above ? Eigen::Vector3d(1, -0.5, 0) : Eigen::Vector3d(0.5, -1, 0)};
  motion.forces.emplace_back(motion.plant.contacts);
  motion.forces[0].contact(0, 0) = 5;  // 1 kg loses 0.5 m/s within 0.1 s
  return motion;
}

TEST(ContactReplay, FollowsPlanAmongSeveralSolutionsAndCountsOthers) {
  int ambiguous = 0;
  for (const bool above : {false, true}) {
    const ContactReplay replay = replay_contacts(past_a_corner(above), {});
    EXPECT_EQ(replay.each_step.lost_at, -1);
    EXPECT_LT(replay.each_step.deviation, 1e-9) << (above ? "above" : "at the side");
    EXPECT_LT(replay.controls.deviation, 1e-9);
    ambiguous += replay.ambiguous_steps;
    if (replay.ambiguous_steps > 0) {
      EXPECT_NEAR(replay.ambiguous.deviation, 0.5, 1e-9);
      EXPECT_EQ(replay.ambiguous.knot, 1);
    }
  }
  // Without guidance, the simulator finds one of the two solutions.
  EXPECT_EQ(ambiguous, 1);
}

TEST(ContactReplay, FeedbackBringsTheMotionBack) {
  ContactMotion motion = thrown_block();
  // The plan claims a different end point; only feedback tries to reach it.
  for (int k = 45; k <= motion.steps(); ++k) motion.q[k][0] += 0.01;
  Eigen::MatrixXd gain = Eigen::MatrixXd::Zero(3, 6);
  gain(0, 0) = -1000;
  const std::vector<Eigen::MatrixXd> gains(motion.steps(), gain);
  const ContactReplay replay = replay_contacts(motion, gains);
  ASSERT_TRUE(replay.feedback_fine);
  EXPECT_GT(replay.feedback_fine->saturated, 0);
}

}  // namespace
}  // namespace conddp
