#include "mpc/swing_starts.hpp"

#include <algorithm>
#include <stdexcept>

#include <gtest/gtest.h>

#include "loop_cases.hpp"

namespace conddp {
namespace {

constexpr int kReference = 1;  ///< offset of the foot position in a node's parameters

/// Two swings of one foot, whose position is in the first three state entries, on a line of 40
/// knots of 0.05 s.
struct TwoSwings {
  FootSwings swings{
      .feet = 1,
      .swings = {{.nodes = {20, 21, 22}, .references = {kReference, kReference, kReference}},
                 {.nodes = {10, 11, 12, 13, 14}, .references = std::vector<int>(5, kReference)}},
      .find_feet = [](const double* x, double* places) { std::copy_n(x, 3, places); }};
  TimeLine line{testing::balanced_cartpole(), true};
  SwingStarts starts{swings, line};

  /// Reports the foot at a displacement along x, y, and z from its foothold, the reference at the
  /// start of a swing.
  void see(double time, int first, const std::vector<double>& beside) {
    const double* foothold = line.numbers(first).parameters + kReference;
    std::vector<double> x(4);
    for (int c = 0; c < 3; ++c) x[c] = foothold[c] + beside[c];
    starts.see(line, time, x.data());
  }
  /// Displacement of a node's references.
  std::vector<double> displacement(int node) const {
    std::vector<double> parameters(6, 1.0);
    starts.displace(node, parameters.data());
    EXPECT_EQ(parameters[0], 1);
    EXPECT_EQ(parameters[4], 1);
    return {parameters[1] - 1, parameters[2] - 1, parameters[3] - 1};
  }
};

void expect_shares(const std::vector<double>& found, const std::vector<double>& of, double share) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], share * of[c], 1e-12) << c;
}

TEST(SwingStarts, SingleNodeLeadsToTheLandingPlace) {
  TwoSwings foot;
  foot.swings.swings = {{.nodes = {10}, .references = {kReference}}};
  foot.starts = SwingStarts(foot.swings, foot.line);
  foot.see(0.5, 10, {0.02, -0.01, 0.03});
  expect_shares(foot.displacement(10), {0.02, -0.01, 0.03}, 0);
}

TEST(SwingStarts, LeadFromLiftOffToTheLandingPlace) {
  TwoSwings foot;
  const std::vector<double> beside = {0.02, -0.01, 0.03};
  foot.see(0.3, 10, beside);
  expect_shares(foot.displacement(10), beside, 1);
  expect_shares(foot.displacement(11), beside, 0.84375);
  expect_shares(foot.displacement(12), beside, 0.5);
  expect_shares(foot.displacement(14), beside, 0);
  expect_shares(foot.displacement(9), beside, 0);
  expect_shares(foot.displacement(20), beside, 0);  // begins at the end of the first
}

TEST(SwingStarts, StayAtLiftOffValuesDuringASwing) {
  TwoSwings foot;
  const std::vector<double> beside = {0.02, -0.01, 0.03}, later = {0.3, 0, 0};
  foot.see(0.5, 10, beside);
  foot.see(0.55, 10, {9, 9, 9});
  expect_shares(foot.displacement(12), beside, 0.5);
  foot.see(0.7, 20, later);  // has landed
  expect_shares(foot.displacement(12), later, 0);
  expect_shares(foot.displacement(21), later, 0.5);
  foot.see(1.2, 20, later);
  expect_shares(foot.displacement(21), later, 0);
}

TEST(SwingStarts, IncludeOnlySwingsOfTheLine) {
  TwoSwings foot;
  foot.swings.swings[0].nodes[2] = 41;
  EXPECT_THROW(SwingStarts(foot.swings, foot.line), std::invalid_argument);
  foot.swings.swings[0] = {.foot = 1, .nodes = {1}, .references = {0}};
  EXPECT_THROW(SwingStarts(foot.swings, foot.line), std::invalid_argument);
}

}  // namespace
}  // namespace conddp
