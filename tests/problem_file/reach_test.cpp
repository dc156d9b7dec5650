// Reachability of the tip of two rods of 0.5 and 0.4 m whose first joint is at the origin.
#include <gtest/gtest.h>

#include "problem_text.hpp"

namespace conddp {
namespace {

/// Messages about reach with these keys after the frame of a cost.
std::string said(const std::string& keys, const std::string& part = "costs") {
  const std::string all = warnings(R"(conddp: 1
robot: {urdf: robots/double_pendulum.urdf}
initial_state: {joints: {shoulder: 0.4}}
phases: [{knots: 3, dt: 0.02}]
costs: {effort: {residual: control}}
terminal: {)" + part + ": {goal: {frame: tip, " +
                                   keys + "}}}\nsolver: {name: altro}\n");
  return all.find("out of reach") == std::string::npos ? "" : all;
}

TEST(Reach, EndsAtFullyStretchedLinks) {
  EXPECT_EQ(said("residual: frame_position, reference: [0, 0, -0.9]"), "");
  EXPECT_EQ(said("residual: frame_placement, reference: {position: [0.8, 0, 0.4], rpy: [0, 0, 0]}"),
            "");
  EXPECT_NE(said("residual: frame_position, reference: [0, 0, -1.1]")
                .find("[0, 0, -1.1] is out of reach of 'tip': the nearest place found within the "
                      "limits of its joints is 0.2 m away"),
            std::string::npos);
  EXPECT_NE(said("residual: frame_placement, reference: {position: [0.8, 0, 0.5], rpy: [0, 0, 0]}"),
            "");
  EXPECT_NE(said("residual: frame_position, reference: [0, 2, 0]", "constraints"), "");
}

TEST(Reach, EndsWhereFoldedLinksAndLimitsEnd) {
  EXPECT_EQ(said("residual: frame_position, reference: [0.1, 0, 0]"), "");
  EXPECT_NE(said("residual: frame_position, reference: [0.05, 0, 0]"), "");
  // A rod in the plane y = 0 cannot leave it.
  EXPECT_NE(said("residual: frame_position, reference: [0.3, 0.2, -0.5]"), "");
}

TEST(Reach, CountsIfAllComponentsDo) {
  EXPECT_EQ(said("residual: frame_position, reference: [0, 9, -1], weights: {y: 0}"), "");
  EXPECT_EQ(
      said("residual: frame_position, reference: [0, 9, -1], equals: {x: 0, z: 0}", "constraints"),
      "");
}

}  // namespace
}  // namespace conddp
