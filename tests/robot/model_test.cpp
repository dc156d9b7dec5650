#include "robot/model.hpp"

#include <stdexcept>

#include <gtest/gtest.h>

#include "support/random_robot.hpp"

namespace conddp {
namespace {

Joint joint(const char* name, int parent, JointType type = JointType::revolute) {
  Joint j;
  j.name = name;
  j.parent = parent;
  j.type = type;
  return j;
}

RobotModel model_of(std::vector<Joint> joints) {
  RobotModel model;
  model.joints = std::move(joints);
  return model;
}

TEST(RobotModel, NumbersConfigurationAndVelocity) {
  RobotModel model = model_of({joint("base", -1, JointType::floating), joint("a", 0), joint("b", 1),
                               joint("c", 0), joint("d", -1)});
  model.finalize();
  EXPECT_EQ(model.nq, 11);
  EXPECT_EQ(model.nv, 10);
  EXPECT_EQ(model.joints[3].q, 9);
  EXPECT_EQ(model.joints[3].v, 8);
  EXPECT_EQ(model.parent_dof, (std::vector<int>{-1, 0, 1, 2, 3, 4, 5, 6, 5, -1}));
  EXPECT_EQ(model.subtree_end, (std::vector<int>{9, 9, 9, 9, 9, 9, 8, 8, 9, 10}));
  EXPECT_EQ(model.root, (std::vector<int>{0, 0, 0, 0, -1}));
}

TEST(RobotModel, SubtreesMatchAncestors) {
  for (const TestModel& entry : random_robots()) {
    const RobotModel& model = entry.model;
    for (int i = 0; i < model.nv; ++i)
      for (int j = 0; j <= i; ++j) {
        bool hangs_on = false;
        for (int k = i; k >= 0; k = model.parent_dof[k]) hangs_on = hangs_on || k == j;
        EXPECT_EQ(i < model.subtree_end[j], hangs_on) << entry.name << " " << i << " " << j;
      }
  }
}

TEST(RobotModel, RejectsOrdersThatAreNotDepthFirst) {
  RobotModel model = model_of({joint("a", -1), joint("b", 0), joint("c", 0), joint("d", 1)});
  EXPECT_THROW(model.finalize(), std::logic_error);
}

TEST(RobotModel, RejectsAFloatingJointOnABody) {
  RobotModel model = model_of({joint("a", -1), joint("b", 0, JointType::floating)});
  EXPECT_THROW(model.finalize(), std::logic_error);
}

TEST(RobotModel, FindsLinksBeforeJointsOfTheSameName) {
  RobotModel model = model_of({joint("arm", -1)});
  model.frames = {{"arm", FrameKind::joint, 0, {}}, {"arm", FrameKind::link, 0, {}}};
  model.finalize();
  EXPECT_EQ(model.find_frame("arm"), 1);
  EXPECT_EQ(model.find_joint("arm"), 0);
  EXPECT_FALSE(model.find_frame("leg"));
  EXPECT_FALSE(model.find_joint("leg"));
}

}  // namespace
}  // namespace conddp
