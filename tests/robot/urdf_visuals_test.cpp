#include "robot/urdf/urdf_visuals.hpp"

#include <cmath>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(UrdfVisuals, ShapesWithSizesPlacesAndColours) {
  const auto links = urdf_visuals(R"(<robot name="r">
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
  ASSERT_EQ(links.size(), 3u);
  EXPECT_EQ(links[0].link, "a");
  const auto& shapes = links[0].visual;
  ASSERT_EQ(shapes.size(), 2u);
  EXPECT_EQ(shapes[0].kind, ShapeKind::box);
  EXPECT_EQ(shapes[0].size.z, 0.3);
  EXPECT_EQ(shapes[0].placement.p.y, 2);
  EXPECT_NEAR(shapes[0].placement.R(1, 0), 1, 1e-15);
  EXPECT_EQ(*shapes[0].color, (std::array<double, 4>{1, 0, 0, 0.5}));
  EXPECT_EQ(shapes[1].kind, ShapeKind::cylinder);
  EXPECT_EQ(shapes[1].size.y, 2);
  EXPECT_EQ(*shapes[1].color, (std::array<double, 4>{0, 1, 0, 1})) << "kept within 0 to 1";
  ASSERT_EQ(links[0].collision.size(), 1u);
  EXPECT_EQ(links[0].collision[0].size.x, 9);
  EXPECT_TRUE(links[1].visual.empty());
  EXPECT_EQ(links[1].collision.at(0).size.x, 0.25);
  EXPECT_EQ(links[2].visual.at(0).mesh, "package://p/m.stl");
  EXPECT_EQ(links[2].visual[0].size.z, -1);
}

TEST(UrdfVisuals, RollPitchYawIsRzRyRx) {
  const auto links = urdf_visuals(R"(<robot name="r"><link name="a"><visual>
    <origin rpy="0.3 -0.4 0.5"/><geometry><sphere radius="1"/></geometry></visual></link></robot>)");
  ASSERT_EQ(links.size(), 1u);
  ASSERT_EQ(links[0].visual.size(), 1u);
  const Matrix3<double>& R = links[0].visual[0].placement.R;
  EXPECT_NEAR(R(2, 0), std::sin(0.4), 1e-15);
  EXPECT_NEAR(R(2, 1), std::cos(0.4) * std::sin(0.3), 1e-15);
  EXPECT_NEAR(R(1, 0), std::sin(0.5) * std::cos(0.4), 1e-15);
}

TEST(UrdfVisuals, UnreadableVisualsAreUnknown) {
  EXPECT_TRUE(urdf_visuals("").empty());
  EXPECT_TRUE(urdf_visuals("<robot><link").empty());
  const auto links = urdf_visuals(R"(<robot><link name="a">
    <visual><geometry><box size="1 nan 1"/></geometry></visual>
    <visual><geometry><box size="1"/></geometry></visual>
    <visual><geometry><cylinder radius="1"/></geometry></visual>
    <visual><geometry><capsule radius="1" length="1"/></geometry></visual>
    <visual><geometry/></visual><visual/></link></robot>)");
  ASSERT_EQ(links.size(), 1u);
  ASSERT_EQ(links[0].visual.size(), 6u);
  for (const VisualShape& shape : links[0].visual) EXPECT_EQ(shape.kind, ShapeKind::unknown);
  EXPECT_EQ(links[0].visual[3].mesh, "capsule");
  EXPECT_EQ(links[0].visual[5].mesh, "");
}

TEST(UrdfVisuals, InertiaIsAboutTheLinkOrigin) {
  const auto links = urdf_visuals(R"(<robot name="r"><link name="a"><inertial>
    <origin xyz="0 0 0.5" rpy="0 0 1.5707963267948966"/><mass value="2"/>
    <inertia ixx="0.1" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.3"/></inertial></link>
    <link name="b"/>
    <link name="c"><inertial><mass value="0"/><inertia ixx="1" iyy="1" izz="1"/></inertial></link>
  </robot>)");
  ASSERT_EQ(links.size(), 3u);
  ASSERT_TRUE(links[0].inertia);
  EXPECT_EQ(links[0].inertia->mass, 2);
  EXPECT_NEAR(links[0].inertia->moment.z, 1, 1e-15);
  // A quarter turn swaps x and y; 2 kg at 0.5 m add 0.5 kg m² across z.
  EXPECT_NEAR(links[0].inertia->rotational.xx, 0.2 + 0.5, 1e-15);
  EXPECT_NEAR(links[0].inertia->rotational.yy, 0.1 + 0.5, 1e-15);
  EXPECT_NEAR(links[0].inertia->rotational.zz, 0.3, 1e-15);
  EXPECT_FALSE(links[1].inertia);
  EXPECT_FALSE(links[2].inertia);
}

TEST(UrdfVisuals, InertiaNeedsMassAndMatrix) {
  const auto links = urdf_visuals(R"(<robot name="r">
    <link name="a"><inertial><mass value="2"/></inertial></link>
    <link name="b"><inertial><inertia ixx="1" iyy="2" izz="3"/></inertial></link>
    <link name="c"><inertial><mass value="-1"/><inertia ixx="1"/></inertial></link>
    <link name="d"><inertial><origin xyz="0.1 0.2 0.3"/><mass value="2"/>
      <inertia ixx="0.11" ixy="0.12" ixz="0.13" iyy="0.22" iyz="0.23" izz="0.33"/></inertial></link>
  </robot>)");
  ASSERT_EQ(links.size(), 4u);
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(links[i].inertia) << i;
  ASSERT_TRUE(links[3].inertia);
  // 2 kg at c = (0.1, 0.2, 0.3) add 2 (cᵀc 1 − c cᵀ).
  const Symmetric3<double>& j = links[3].inertia->rotational;
  EXPECT_NEAR(j.xx, 0.11 + 2 * 0.13, 1e-15);
  EXPECT_NEAR(j.yy, 0.22 + 2 * 0.10, 1e-15);
  EXPECT_NEAR(j.zz, 0.33 + 2 * 0.05, 1e-15);
  EXPECT_NEAR(j.xy, 0.12 - 2 * 0.02, 1e-15);
  EXPECT_NEAR(j.xz, 0.13 - 2 * 0.03, 1e-15);
  EXPECT_NEAR(j.yz, 0.23 - 2 * 0.06, 1e-15);
  EXPECT_NEAR(links[3].inertia->moment.y, 0.4, 1e-15);
}

TEST(UrdfVisuals, OwnMaterialColorOverridesTheRobots) {
  const auto links = urdf_visuals(R"(<robot name="r">
    <material name="red"><color rgba="1 0 0 1"/></material>
    <link name="a">
      <visual><geometry><sphere radius="1"/></geometry>
        <material name="red"><color rgba="0 0.25 2 -1"/></material></visual>
      <visual><geometry><sphere radius="1"/></geometry><material name="red"/></visual>
      <visual><geometry><sphere radius="1"/></geometry><material name="blue"/></visual>
      <visual><geometry><sphere radius="1"/></geometry><material/></visual>
    </link></robot>)");
  ASSERT_EQ(links.size(), 1u);
  using Colour = std::array<double, 4>;
  EXPECT_EQ(links[0].visual[0].color, (Colour{0, 0.25, 1, 0}));
  EXPECT_EQ(links[0].visual[1].color, (Colour{1, 0, 0, 1}));
  EXPECT_FALSE(links[0].visual[2].color);
  EXPECT_FALSE(links[0].visual[3].color);
}

}  // namespace
}  // namespace conddp
