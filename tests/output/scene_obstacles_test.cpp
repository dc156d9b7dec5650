#include "output/scene/scene_obstacles.hpp"

#include <cmath>

#include "output/scene/motion_scene.hpp"
#include "report_fixture.hpp"

namespace conddp {
namespace {

TEST_F(Report, ShowsFileObstaclesAndLinkShapes) {
  load("arm_obstacles.yaml");
  const OrderedJson list = obstacles_json(*built_);
  EXPECT_EQ(named(list, "ball")["kind"], "sphere");
  EXPECT_EQ(named(list, "ball")["center"], (OrderedJson{0.6, 0.0, 0.4}));
  EXPECT_EQ(named(list, "ball")["radius"], 0.2);
  EXPECT_EQ(named(list, "pole")["to"], (OrderedJson{0.6, 0.0, 1.2}));
  EXPECT_EQ(named(list, "table")["normal"], (OrderedJson{0.0, 0.0, 1.0}));

  const RobotModel& robot = built_->plant.robot();
  const OrderedJson shapes = collision_shapes_json(spec_->collision, robot);
  ASSERT_EQ(shapes.size(), spec_->collision.shapes.size());
  const Frame& frame = robot.frames[*robot.find_frame("link_5")];
  const OrderedJson& forearm = named(shapes, "forearm");
  EXPECT_EQ(forearm["body"], frame.joint + 1);
  const Vector3<double> end = frame.placement.R * Vector3<double>{0, 0, 0.14} + frame.placement.p;
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(forearm["to"][i].get<double>(), end[i], 1e-12);
}

TEST_F(Report, BodiesAreHullsOfTheirCorners) {
  load("arm_shelf.yaml");
  const OrderedJson list = obstacles_json(*built_);
  const OrderedJson& board = named(list, "board");
  EXPECT_EQ(board["kind"], "hull");
  EXPECT_EQ(board["inside"], false);
  ASSERT_EQ(board["points"].size(), 8u);
  for (const OrderedJson& point : board["points"]) {
    EXPECT_NEAR(std::abs(point[1].get<double>()), 0.4, 1e-12);
    EXPECT_NEAR(std::abs(point[2].get<double>() - 0.6), 0.01, 1e-12);
  }
  for (const OrderedJson& point : named(list, "bottle")["points"])
    EXPECT_GE(point[2].get<double>(), 0.61 - 1e-12);
  const OrderedJson shapes =
      collision_shapes_json(built_->facts().collision, built_->plant.robot());
  EXPECT_EQ(named(shapes, "link_3")["points"].size(), 64u);
  EXPECT_EQ(named(shapes, "link_7")["kind"], "capsule");
}

TEST_F(Report, SceneHasTheTerrainAndItsNormals) {
  load("quadruped_stairs.yaml");
  const OrderedJson stairs = obstacles_json(*built_);
  EXPECT_EQ(named(stairs, "ground")["kind"], "half_space");
  EXPECT_EQ(named(stairs, "stair_3")["kind"], "hull");
  EXPECT_EQ(named(stairs, "stair_3")["terrain"], true);

  load("quadruped_hills.yaml");
  const OrderedJson hills = obstacles_json(*built_);
  const OrderedJson& map = named(hills, "hills");
  EXPECT_EQ(map["kind"], "heights");
  EXPECT_EQ(map["columns"], 19);
  EXPECT_EQ(map["heights"].size(), 19u * 9u);
  EXPECT_EQ(map["heights"][8], 0.03);
  Trajectory trajectory = built_->guess;  // the robot stands on level ground
  trajectory.x(trajectory.knots()).data()[0] += 1;
  const OrderedJson scene = motion_scene(*built_, trajectory);
  const OrderedJson& normals = named(scene["contacts"], "LH")["normals"];
  EXPECT_EQ(normals[2], 1.0);
  EXPECT_LT(normals[3 * trajectory.knots() + 2].get<double>(), 0.99);
}

TEST_F(Report, ConstraintsOnPositionsBecomeDiscsBallsAndBoxes) {
  load("unicycle_obstacles.yaml");
  const OrderedJson discs = obstacles_json(*built_);
  const OrderedJson& disc = named(discs, "disc_3");
  EXPECT_EQ(disc["kind"], "disc");
  EXPECT_EQ(disc["center"], (OrderedJson{2.25, 2.25, 0.0}));
  EXPECT_EQ(disc["normal"], (OrderedJson{0, 0, 1}));
  EXPECT_EQ(disc["radius"], 0.425);
  EXPECT_EQ(disc["inside"], false);
  EXPECT_EQ(named(discs, "terminal/goal")["lower"], (OrderedJson{3.0, 3.0, nullptr}));

  load("arm_waypoint.yaml",
       {"constraints.clear={residual: frame_position, frame: tip, reference: [0.1, 0, 0.2], "
        "at_least: 0.3, at_most: 5}",
        "constraints.low={residual: frame_position, frame: tip, reference: [0, 0, 0], upper: {z: "
        "1.5}}",
        "constraints.moving={residual: frame_position, frame: tip, at_least: 0.1, reference: "
        "{times: [0, 1.2], values: [[0, 0, 0], [0, 0, 6]]}}"});
  const OrderedJson list = obstacles_json(*built_);
  const OrderedJson& ball = named(list, "clear");
  EXPECT_EQ(ball["kind"], "sphere");
  EXPECT_EQ(ball["center"], (OrderedJson{0.1, 0.0, 0.2}));
  EXPECT_EQ(ball["radius"], 0.3);
  int around = 0;
  for (const OrderedJson& entry : list)
    around += entry["name"] == "clear" && entry["radius"] == 5.0 && entry["inside"] == true;
  EXPECT_EQ(around, 1);
  EXPECT_EQ(named(list, "low")["upper"], (OrderedJson{nullptr, nullptr, 1.5}));
  EXPECT_EQ(named(list, "through")["lower"], (OrderedJson{0.7, nullptr, -0.2}));
  const OrderedJson& centers = named(list, "moving")["centers"];
  ASSERT_EQ(centers.size(), 3u * 61);
  EXPECT_NEAR(centers[3 * 30 + 2].get<double>(), 3, 1e-7);
  for (const OrderedJson& entry : list) EXPECT_NE(entry["name"], "speed");
}

TEST_F(Report, DrawsBoundsOnPositionsOnly) {
  load("double_integrator_limits.yaml");
  const OrderedJson list = obstacles_json(*built_);
  ASSERT_EQ(list.size(), 1u);  // the goal
  EXPECT_EQ(list[0]["lower"], (OrderedJson{1.0, nullptr, nullptr}));
}

}  // namespace
}  // namespace conddp
