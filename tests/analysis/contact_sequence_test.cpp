#include "analysis/contact/contact_sequence.hpp"

#include "support/thrown_block.hpp"

namespace conddp {
namespace {

TEST(ContactSequence, OfABlockThatFallsSlidesAndStops) {
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
  // It lands at the end of the last step of the flight.
  EXPECT_GT(motion.q[flight.steps - 1][1], 0.5 + 1e-3);
  EXPECT_NEAR(motion.q[flight.steps][1], 0.5, 1e-9);
}

// The landing and a contact of one step are no contacts of a schedule, but nor are they nothing.
TEST(ContactSequence, ForcesThatNoContactAccountsForAreTold) {
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

TEST(ContactSequence, WhatRestsAtTheStartDoesNotLand) {
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

TEST(ContactSequence, ShortInterruptionsAreLeftOut) {
  ContactMotion motion = thrown_block();
  const int middle = (contact_sequence(motion)[1].first + motion.steps()) / 2;
  motion.forces[middle].contact(0, 1) = 0;  // where it touches all the same
  const auto sequence = contact_sequence(motion);
  ASSERT_EQ(sequence.size(), 2u);
  EXPECT_EQ(sequence[0].closed, std::vector<bool>(4, false));
  EXPECT_EQ(sequence[1].closed, (std::vector<bool>{true, true, false, false}));
  EXPECT_EQ(contact_sequence(motion, {.shortest = 1}).size(), 4u);
  motion.forces[middle + 1].contact(0, 1) = 0;
  EXPECT_EQ(contact_sequence(motion).size(), 4u);
}

}  // namespace
}  // namespace conddp
