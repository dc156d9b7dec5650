#include "robot/urdf_visuals.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(UrdfVisuals, ShapesWithSizesPlacesAndColours) {
  const auto shapes = urdf_visuals(R"(<robot name="r">
    <material name="red"><color rgba="1 0 0 0.5"/></material>
    <link name="a">
      <visual>
        <origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/>
        <geometry><box size="0.1 0.2 0.3"/></geometry>
        <material name="red"/>
      </visual>
      <visual><geometry><cylinder radius="0.5" length="2"/></geometry>
        <material name="own"><color rgba="0 2 0 1"/></material></visual>
      <collision><geometry><sphere radius="9"/></geometry></collision>
    </link>
    <link name="b"><collision><geometry><sphere radius="0.25"/></geometry></collision></link>
    <link name="c"><visual><geometry>
      <mesh filename="package://p/m.stl" scale="1 1 -1"/></geometry></visual></link>
  </robot>)");
  ASSERT_EQ(shapes.size(), 4u);
  EXPECT_EQ(shapes[0].link, "a");
  EXPECT_EQ(shapes[0].kind, ShapeKind::box);
  EXPECT_EQ(shapes[0].size.z, 0.3);
  EXPECT_EQ(shapes[0].placement.p.y, 2);
  EXPECT_NEAR(shapes[0].placement.R(1, 0), 1, 1e-15);
  EXPECT_EQ(*shapes[0].color, (std::array<double, 4>{1, 0, 0, 0.5}));
  EXPECT_EQ(shapes[1].kind, ShapeKind::cylinder);
  EXPECT_EQ(shapes[1].size.y, 2);
  EXPECT_EQ(*shapes[1].color, (std::array<double, 4>{0, 1, 0, 1})) << "kept within 0 to 1";
  EXPECT_EQ(shapes[2].link, "b") << "the collision shape stands in for a visual one";
  EXPECT_EQ(shapes[2].size.x, 0.25);
  EXPECT_EQ(shapes[3].mesh, "package://p/m.stl");
  EXPECT_EQ(shapes[3].size.z, -1);
}

TEST(UrdfVisuals, RollPitchYawIsRzRyRx) {
  const auto shapes = urdf_visuals(R"(<robot name="r"><link name="a"><visual>
    <origin rpy="0.3 -0.4 0.5"/><geometry><sphere radius="1"/></geometry></visual></link></robot>)");
  ASSERT_EQ(shapes.size(), 1u);
  const Matrix3<double>& R = shapes[0].placement.R;
  EXPECT_NEAR(R(2, 0), std::sin(0.4), 1e-15);
  EXPECT_NEAR(R(2, 1), std::cos(0.4) * std::sin(0.3), 1e-15);
  EXPECT_NEAR(R(1, 0), std::sin(0.5) * std::cos(0.4), 1e-15);
}

TEST(UrdfVisuals, WhatCannotBeReadIsLeftOut) {
  EXPECT_TRUE(urdf_visuals("").empty());
  EXPECT_TRUE(urdf_visuals("<robot><link").empty());
  EXPECT_TRUE(urdf_visuals(R"(<robot><link name="a">
    <visual><geometry><box size="1 nan 1"/></geometry></visual>
    <visual><geometry><box size="1"/></geometry></visual>
    <visual><geometry><cylinder radius="1"/></geometry></visual>
    <visual><geometry/></visual><visual/></link></robot>)")
                  .empty());
}

}  // namespace
}  // namespace conddp
