#include "analysis/contact/contact_motion.hpp"
#include "support/block_on_slides.hpp"
#include "support/thrown_block.hpp"

namespace conddp {
namespace {

TEST(ContactSequence, DescribesABlockThatFallsSlidesAndStops) {
  const ContactMotion motion = thrown_block();
  const auto sequence = contact_sequence(motion);
  ASSERT_EQ(sequence.size(), 2u);
  const ContactStretch &flight = sequence[0], &ground = sequence[1];
  EXPECT_EQ(flight.closed, std::vector<bool>(4, false));
  EXPECT_FALSE(flight.lands());
  EXPECT_EQ(ground.closed, (std::vector<bool>{true, true, false, false}));
  EXPECT_EQ(ground.landing, ground.closed);
  EXPECT_EQ(ground.slides, ground.closed);
  EXPECT_EQ(flight.steps + ground.steps, motion.steps());
  // Landing occurs at the end of the last flight step.
  EXPECT_GT(motion.q[flight.steps - 1][1], 0.5 + 1e-3);
  EXPECT_NEAR(motion.q[flight.steps][1], 0.5, 1e-9);
}

// The landing and a one-step contact do not appear in the schedule, but their forces are reported.
TEST(ContactSequence, ReportsForcesOutsideAllContacts) {
  ContactMotion motion = thrown_block();
  const auto sequence = contact_sequence(motion);
  const ContactStretch& flight = sequence[0];
  ASSERT_EQ(flight.pushes.size(), 4u);
  EXPECT_EQ(flight.pushes[0].steps, 1);
  EXPECT_EQ(flight.pushes[0].largest, motion.forces[flight.steps - 1].contact(0, 0));
  EXPECT_EQ(flight.pushes[2].steps, 0);
  EXPECT_EQ(sequence[1].pushes[0].steps, 0);
  motion.forces[flight.steps + 3].contact(0, 2) = 27;
  const auto pushed = contact_sequence(motion);
  ASSERT_EQ(pushed.size(), 2u);
  EXPECT_EQ(pushed[1].pushes[2].steps, 1);
  EXPECT_EQ(pushed[1].pushes[2].largest, 27);
}

TEST(ContactSequence, InitialContactIsNotALanding) {
  ContactMotion motion = thrown_block();
  const int landed = contact_sequence(motion)[1].first;
  for (auto* list : {&motion.q, &motion.v}) list->erase(list->begin(), list->begin() + landed);
  motion.h.erase(motion.h.begin(), motion.h.begin() + landed);
  motion.u.erase(motion.u.begin(), motion.u.begin() + landed);
  motion.forces.erase(motion.forces.begin(), motion.forces.begin() + landed);
  const auto sequence = contact_sequence(motion);
  ASSERT_EQ(sequence.size(), 1u);
  EXPECT_FALSE(sequence[0].lands());
}

TEST(ContactSequence, DropsShortInterruptions) {
  ContactMotion motion = thrown_block();
  const int middle = (contact_sequence(motion)[1].first + motion.steps()) / 2;
  motion.forces[middle].contact(0, 1) = 0;  // still touching
  const auto sequence = contact_sequence(motion);
  ASSERT_EQ(sequence.size(), 2u);
  EXPECT_EQ(sequence[0].closed, std::vector<bool>(4, false));
  EXPECT_EQ(sequence[1].closed, (std::vector<bool>{true, true, false, false}));
  EXPECT_EQ(contact_sequence(motion, {.shortest = 1}).size(), 4u);
  motion.forces[middle + 1].contact(0, 1) = 0;
  EXPECT_EQ(contact_sequence(motion).size(), 4u);
}

/// A block of 2 kg on slides (4 kg in total) with a ball below it and a second ball 0.2 m above the
/// ground that moves along x only. Each step lists the initial height of the first ball, the final
/// speeds along x and y, and the ball's force.
struct SlideStep {
  double height, along_x, along_y, force;
};
ContactMotion slide_steps(const std::vector<SlideStep>& steps) {
  ContactMotion motion;
  motion.plant.robot = testing::block_on_slides();
  for (const auto& [link, height] : {std::pair{"block", 0.0}, {"cart_x", 0.3}})
    motion.plant.contacts.candidates.push_back(
        {.name = "ball",
         .sphere = {.frame = *motion.plant.robot->find_frame(link),
                    .center = {0, 0, height},
                    .radius = 0.1},
         .against = ContactHalfSpace{},
         .friction = 0.5});
  motion.v.emplace_back(Eigen::Vector3d::Zero());
  for (const SlideStep& step : steps) {
    motion.h.push_back(0.1);
    motion.q.emplace_back(Eigen::Vector3d(0, 0, 0.1 + step.height));
    motion.v.emplace_back(Eigen::Vector3d(step.along_x, step.along_y, 5));
    motion.forces.emplace_back(motion.plant.contacts);
    motion.forces.back().contact(0, 0) = step.force;
  }
  motion.q.push_back(motion.q.back());
  return motion;
}

/// "0-2: closed sliding landing; 2-3: open".
std::string story(const std::vector<ContactStretch>& sequence) {
  std::string text;
  for (const ContactStretch& s : sequence) {
    text += (text.empty() ? "" : "; ") + std::to_string(s.first) + "-" +
            std::to_string(s.first + s.steps) + (s.closed[0] ? ": closed" : ": open");
    if (s.slides[0]) text += " sliding";
    if (s.landing[0]) text += " landing";
    EXPECT_EQ(s.lands(), s.landing[0]);
    EXPECT_FALSE(s.closed[1] || s.slides[1] || s.landing[1]);
  }
  return text;
}

// Thresholds: a ten-thousandth of the weight for forces, 10 µm for gaps, 1 cm/s for slip.
TEST(ContactSequence, CountsForcesGapsAndSlipsAtThresholds) {
  const double weight = 4 * 9.81;
  const SlideStep stands = {0, 0, 0, 10};
  EXPECT_EQ(story(contact_sequence(slide_steps({stands, stands, stands}))), "0-3: closed");
  for (const auto& [height, force, expected] : {std::tuple{0.9e-5, 1.1e-4 * weight, "0-2: closed"},
                                                {1.1e-5, 10.0, "0-2: open"},
                                                {0.0, 0.9e-4 * weight, "0-2: open"}}) {
    const SlideStep step = {height, 0, 0, force};
    EXPECT_EQ(story(contact_sequence(slide_steps({step, step}))), expected) << height;
  }
  EXPECT_EQ(story(contact_sequence(slide_steps({stands, {0, 0.011, 0, 10}}))),
            "0-2: closed sliding");
  EXPECT_EQ(story(contact_sequence(slide_steps({stands, {0, 0, -0.011, 10}}))),
            "0-2: closed sliding");
  EXPECT_EQ(story(contact_sequence(slide_steps({stands, {0, 0.009, 0, 10}}))), "0-2: closed");
  // Tangential speed in the air is not slip.
  EXPECT_EQ(story(contact_sequence(slide_steps({{1, 3, 0, 0}, {1, 3, 0, 0}, stands, stands}))),
            "0-2: open; 2-4: closed landing");
}

TEST(ContactSequence, DropsRunsShorterThanRequested) {
  const SlideStep stands = {0, 0, 0, 10}, flies = {1, 0, 0, 0}, hovers = {0, 0, 0, 0};
  const auto told = [](const std::vector<SlideStep>& steps, int shortest) {
    return story(contact_sequence(slide_steps(steps), {.shortest = shortest}));
  };
  // One step without force while still touching.
  const std::vector<SlideStep> rest = {stands, stands, hovers, stands, stands};
  EXPECT_EQ(told(rest, 2), "0-5: closed");
  EXPECT_EQ(told(rest, 1), "0-2: closed; 2-3: open; 3-5: closed landing");
  // A one-step flight counts as a flight.
  EXPECT_EQ(told({stands, stands, flies, stands, stands}, 2),
            "0-2: closed; 2-3: open; 3-5: closed landing");
  // A one-step contact is dropped, except at either end, where it may continue outside the motion.
  const std::vector<SlideStep> touch = {flies, flies, stands, flies, flies};
  EXPECT_EQ(told(touch, 2), "0-5: open");
  EXPECT_EQ(told(touch, 1), "0-2: open; 2-3: closed landing; 3-5: open");
  EXPECT_EQ(told({stands, flies, flies, stands}, 2), "0-1: closed; 1-3: open; 3-4: closed landing");
  const auto pushed = contact_sequence(slide_steps(touch));
  EXPECT_EQ(pushed[0].pushes[0].steps, 1);
  EXPECT_EQ(pushed[0].pushes[0].largest, 10);
  EXPECT_EQ(pushed[0].pushes[1].steps, 0);
}

}  // namespace
}  // namespace conddp
