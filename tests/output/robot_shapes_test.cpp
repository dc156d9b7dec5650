#include "output/scene/robot_shapes.hpp"

#include <map>

#include <gtest/gtest.h>

#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A trunk and a hip with everything else fixed to them.
constexpr const char* kVendorsRobot = R"(<robot name="vendor">
<link name="trunk">
  <inertial><mass value="10"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><mesh filename="package://nowhere/trunk.stl"/></geometry></visual>
  <collision><geometry><box size="0.4 0.2 0.1"/></geometry></collision></link>
<link name="imu"><visual><geometry><box size="0.01 0.01 0.01"/></geometry></visual></link>
<link name="hip">
  <inertial><origin xyz="0 0 0.3"/><mass value="1"/>
    <inertia ixx="0.00058" iyy="0.00208" izz="0.0025" ixy="0" ixz="0" iyz="0"/></inertial>
  <visual><geometry><mesh filename="hip.blend"/></geometry></visual></link>
<link name="rotor"><visual><geometry><cylinder radius="0.05" length="0.02"/></geometry></visual></link>
<link name="foot"><collision><geometry><sphere radius="0.03"/></geometry></collision></link>
<link name="tip"/>
<link name="antenna"><inertial><mass value="1e-6"/>
  <inertia ixx="0.001" iyy="0.001" izz="0.001" ixy="0" ixz="0" iyz="0"/></inertial></link>
<link name="pointer"><visual><geometry><mesh filename="pointer.STL"/></geometry></visual></link>
<link name="mixed"><visual><geometry><sphere radius="0.02"/></geometry></visual>
  <visual><geometry><capsule radius="1" length="1"/></geometry></visual></link>
<joint name="swing" type="revolute"><origin xyz="0.2 0 0"/><parent link="trunk"/><child link="hip"/>
  <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="10" velocity="10"/></joint>
<joint name="f0" type="fixed"><parent link="trunk"/><child link="imu"/></joint>
<joint name="f1" type="fixed"><parent link="hip"/><child link="rotor"/></joint>
<joint name="f2" type="fixed"><origin xyz="0 0 -0.5"/><parent link="hip"/><child link="foot"/></joint>
<joint name="f3" type="fixed"><parent link="hip"/><child link="tip"/></joint>
<joint name="f4" type="fixed"><parent link="hip"/><child link="antenna"/></joint>
<joint name="f5" type="fixed"><parent link="hip"/><child link="pointer"/></joint>
<joint name="f6" type="fixed"><parent link="hip"/><child link="mixed"/></joint>
</robot>)";

RobotShapes shapes_of(const char* urdf) {
  const TemporaryFolder folder;
  folder.write("robot.urdf", urdf);
  folder.write("pointer.STL", "version 1\nsize 123456\n");
  Diagnostics out;
  const auto spec = read_problem_text(R"(conddp: 1
name: vendor
robot: {urdf: robot.urdf, base: floating}
initial_state: {base: {position: [0, 0, 1]}}
phases: [{name: fall, knots: 1, dt: 0.01}]
costs: {effort: {residual: control}}
)",
                                      folder / "problem.yaml", {}, out);
  if (!spec) throw std::runtime_error(format_diagnostics(out, false));
  const auto built = build_problem(*spec, {}, out);
  if (!built) throw std::runtime_error(format_diagnostics(out, false));
  return robot_shapes(*built);
}

/// Shape kinds by link, in order.
std::map<std::string, std::string> kinds(const OrderedJson& shapes) {
  std::map<std::string, std::string> by_link;
  for (const OrderedJson& shape : shapes)
    by_link[shape["link"].get<std::string>()] += shape["kind"].get<std::string>() + " ";
  return by_link;
}

TEST(RobotShapes, EveryLinkHasAShapeDespiteFixedJoints) {
  const RobotShapes shapes = shapes_of(kVendorsRobot);
  ASSERT_EQ(shapes.of_body.size(), 3u);
  EXPECT_EQ(kinds(shapes.of_body[1]),
            (std::map<std::string, std::string>{{"trunk", "box "}, {"imu", "box "}}));
  EXPECT_EQ(kinds(shapes.of_body[2]), (std::map<std::string, std::string>{{"hip", "ellipsoid "},
                                                                          {"rotor", "cylinder "},
                                                                          {"foot", "sphere "},
                                                                          {"antenna", "ellipsoid "},
                                                                          {"mixed", "sphere "}}));
  for (const OrderedJson& shape : shapes.of_body[2]) {
    if (shape["link"] == "hip") {
      // Ellipsoid with half axes a, b, c: I_x = m/5 (b² + c²), and so on.
      const double half_axes[] = {0.1, 0.05, 0.02};
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(shape["radii"][i].get<double>(), half_axes[i], 1e-6) << i;
      EXPECT_NEAR(shape["placement"][2].get<double>(), 0.3, 1e-6);
    }
    if (shape["link"] == "foot") {
      EXPECT_NEAR(shape["placement"][2].get<double>(), -0.5, 1e-6);
    }
  }
}

TEST(RobotShapes, StandInsAreNamedWithTheirReasons) {
  const OrderedJson expected = OrderedJson::parse(R"([
    {"link": "trunk", "drawn_by": "collision shape",
     "reasons": [{"why": "mesh not found", "what": "package://nowhere/trunk.stl"}]},
    {"link": "hip", "drawn_by": "inertia ellipsoid",
     "reasons": [{"why": "mesh format not read", "what": "hip.blend"}]},
    {"link": "foot", "drawn_by": "collision shape",
     "reasons": [{"why": "no visual shape", "what": ""}]},
    {"link": "antenna", "drawn_by": "inertia ellipsoid",
     "reasons": [{"why": "no visual shape", "what": ""}]},
    {"link": "pointer", "drawn_by": "nothing",
     "reasons": [{"why": "no surface inside", "what": "pointer.STL"}]},
    {"link": "mixed", "drawn_by": "other visual shapes",
     "reasons": [{"why": "geometry not read", "what": "capsule"}]}])");
  EXPECT_EQ(shapes_of(kVendorsRobot).stand_ins, expected);
}

TEST(RobotShapes, PlaceholderInertiasDoNotBecomeGiants) {
  // 1e-6 kg with 1e-3 kg m²: the ellipsoid of that inertia has half axes of 50 m.
  const RobotShapes shapes = shapes_of(kVendorsRobot);
  for (const OrderedJson& shape : shapes.of_body[2]) {
    if (shape["link"] != "antenna") continue;
    for (const OrderedJson& radius : shape["radii"]) EXPECT_LE(radius.get<double>(), 0.01);
  }
}

}  // namespace
}  // namespace conddp
