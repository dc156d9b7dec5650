// Contacts of a closed loop's plant, compared with a simulator that always has all candidates.
#include "analysis/contact/simulated_contacts.hpp"

#include <cmath>
#include <set>

#include <gtest/gtest.h>

#include "support/contact_plants.hpp"

namespace conddp {
namespace {

/// The block with its corners as contacts 3, 0, 5, and 1, and the state of its plant: (q, v, push).
struct LoopBlock {
  LoopBlock() : contacts(block, 0.01, {3, 0, 5, 1}, 1), all(block) {}

  /// Advances the state and checks the step against the simulator of all candidates.
  std::uint32_t step(double length, double push) {
    const StepStart start{Eigen::Map<const Eigen::VectorXd>(x.data(), 3),
                          Eigen::Map<const Eigen::VectorXd>(x.data() + 3, 3),
                          Eigen::Vector3d(push, 0, 0), length};
    const ContactStep expected = all.step(start);
    contacts.step(0, length, &push, x.data());
    std::uint32_t closed = 0;
    for (int c = 0; c < 4; ++c)
      if (expected.forces.contact(0, c) > 0) closed |= 1u << bits[c];
    EXPECT_EQ(contacts.closed_contacts(), closed);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(x[i], expected.q[i], 1e-10) << i;
      EXPECT_NEAR(x[3 + i], expected.v[i], 1e-10) << i;
    }
    EXPECT_EQ(x[6], push);
    return closed;
  }

  static constexpr int bits[] = {3, 0, 5, 1};
  ContactPlant block = block_on_slope(0.5);
  SimulatedContacts contacts;
  ContactSimulator all;
  std::vector<double> x = {0, 0.5, 0, 0, 0, 0, 0};
};

// From 0.3 m above the ground, far from contact, into it within one step.
TEST(SimulatedContacts, StepsMatchTheFullSimulator) {
  LoopBlock block;
  block.x = {0.1, 0.8, 0.1, 1, -4, 0.5, 0};
  std::set<std::uint32_t> seen = {block.step(0.02, 0.5)};
  EXPECT_EQ(*seen.begin(), 0u);
  seen.insert(block.step(0.1, 0.5));
  EXPECT_EQ(seen.size(), 2u) << "it has landed";
  for (int k = 0; k < 120; ++k) seen.insert(block.step(0.01, k < 60 ? 3 : -2));
  EXPECT_TRUE(seen.contains(1u << 3 | 1u << 0)) << "it stands";
}

TEST(SimulatedContacts, TiltedBlockLandsOneCornerFirst) {
  for (const double tilt : {0.1, -0.1}) {
    LoopBlock block;
    block.x = {0, 0.62, tilt, 0, 0, 0, 0};
    std::set<std::uint32_t> seen;
    for (int k = 0; k < 60; ++k) seen.insert(block.step(0.01, 0));
    EXPECT_GE(seen.size(), 3u);
    EXPECT_EQ(*seen.begin(), 0u);
    EXPECT_TRUE(seen.contains(1u << 3 | 1u << 0));
  }
}

TEST(SimulatedContacts, UseOnlyClosedContacts) {
  LoopBlock block;
  EXPECT_EQ(block.step(0.01, 1), 1u << 3 | 1u << 0);
  block.x[1] = 0.55;  // near, but in the air
  block.x[4] = 0;
  EXPECT_EQ(block.step(0.01, 1), 0u);
}

TEST(SimulatedContacts, ForcesCarryTheWeight) {
  LoopBlock block;
  block.step(0.01, 1);
  const std::span<const double> forces = block.contacts.contact_forces();
  ASSERT_EQ(forces.size(), 18u);                    // contacts 0 to 5
  EXPECT_NEAR(forces[2] + forces[11], 9.81, 1e-6);  // upwards: 1 kg
  EXPECT_NEAR(forces[0] + forces[9], -1, 1e-6);     // opposes the push; no slip
  for (const int open : {1, 2, 4, 5}) EXPECT_TRUE(std::isnan(forces[3 * open])) << open;
  block.x[1] = 0.55;
  block.x[4] = 0;
  block.step(0.01, 1);
  for (const double number : block.contacts.contact_forces()) EXPECT_TRUE(std::isnan(number));
}

// A non-finite step invalidates the whole state.
TEST(SimulatedContacts, FailedStepMakesWholeStateNaN) {
  LoopBlock block;
  block.step(0.01, 1);
  block.x[5] = std::nan("");
  const double push = 2;
  block.contacts.step(0, 0.01, &push, block.x.data());
  for (const double number : block.x) EXPECT_TRUE(std::isnan(number));
  EXPECT_EQ(block.contacts.closed_contacts(), 0u);
}

TEST(SimulatedContacts, MayStepUntilTheirTimeStepEnds) {
  LoopBlock block;
  EXPECT_EQ(block.contacts.next_stop(0.25), 0.26);
  const std::vector<double> before = block.x;
  block.contacts.pass_instants(0.25, block.x.data());
  EXPECT_EQ(block.x, before);
}

}  // namespace
}  // namespace conddp
