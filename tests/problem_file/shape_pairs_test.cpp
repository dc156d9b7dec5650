// Pairs of shapes of a distance cost, and rejected selections.
#include "problem_file/plant/shape_pairs.hpp"

#include <cmath>

#include "problem_text.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

constexpr std::string_view kArm = R"(conddp: 1
robot: {urdf: robots/arm7.urdf}
collision:
  shapes:
    base: {frame: base, sphere: {radius: 0.1}}
    upper: {frame: link_3, capsule: {radius: 0.05, to: [0, 0, 0.2]}}
    elbow: {frame: link_3, sphere: {radius: 0.05}}
    middle: {frame: link_4, sphere: {radius: 0.05}}
    hand: {frame: tool, sphere: {radius: 0.05}}
  obstacles:
    ball: {sphere: {radius: 0.1, center: [0.5, 0, 0.5]}}
    floor: {half_space: {}}
initial_state: {joints: {joint_2: 0.3}}
phases: [{knots: 2, dt: 0.1}]
costs: {clear: {residual: distance, pairs: all}}
)";

using Names = std::vector<std::string>;

Names pairs_of(const char* choice) {
  const Loaded loaded(replaced(kArm, "pairs: all", std::string("pairs: ") + choice));
  EXPECT_TRUE(loaded.built) << loaded.all();
  Names names;
  if (!loaded.built) return names;
  Diagnostics out;
  for (const ShapePair& pair :
       shape_pairs(loaded.spec->costs[0], *loaded.spec, loaded.built->plant, out))
    names.push_back(pair.first + "-" + pair.second);
  return names;
}

TEST(ShapePairs, SelfPairsExcludeSameLinkAndNeighbours) {
  EXPECT_EQ(pairs_of("self"), (Names{"base-upper", "base-elbow", "base-middle", "base-hand",
                                     "upper-hand", "elbow-hand", "middle-hand"}));
}

TEST(ShapePairs, ObstaclePairsIncludeMovingShapesOnly) {
  EXPECT_EQ(pairs_of("obstacles"),
            (Names{"upper-ball", "upper-floor", "elbow-ball", "elbow-floor", "middle-ball",
                   "middle-floor", "hand-ball", "hand-floor"}));
  EXPECT_EQ(pairs_of("all").size(), 15u);
}

TEST(ShapePairs, NamedPairsMayBeNeighboursAndAppearOnce) {
  EXPECT_EQ(pairs_of("[[floor, hand], [hand, floor], [upper, middle]]"),
            (Names{"hand-floor", "upper-middle"}));
  EXPECT_EQ(pairs_of("[[elbow, '*']]"),
            (Names{"base-elbow", "elbow-middle", "elbow-hand", "elbow-ball", "elbow-floor"}));
}

void expect_error(const char* from, const char* to, const std::string& message) {
  const Loaded loaded(replaced(kArm, from, to));
  EXPECT_FALSE(loaded.built);
  EXPECT_NE(loaded.first_error().find(message), std::string::npos) << loaded.all();
}

TEST(ShapePairs, ImpossiblePairsAreRejectedWithPlaces) {
  expect_error("pairs: all", "pairs: [[hand, bell]]", "15:52: unknown shape 'bell'");
  expect_error("pairs: all", "pairs: [[upper, elbow]]",
               "15:46: 'upper' and 'elbow' do not move relative to each other");
  expect_error("pairs: all", "pairs: [[ball, floor]]", "do not move relative to each other");
  expect_error("pairs: all", "pairs: [[hand]]", "a pair has two names, this list 1");
  expect_error("pairs: all", "pairs: [hand, ball]", "a pair of shapes is expected here");
  expect_error("pairs: all", "pairs: []", "there is no pair");
  expect_error("pairs: all", "margin: 0.1", "'costs.clear' lacks the key 'pairs'");
  expect_error("pairs: all", "pairs: all, margin: 0.1, activation: quadratic",
               "'margin' and 'activation' exclude each other");
  expect_error("residual: distance, pairs: all", "residual: control, pairs: all",
               "the residual 'control' has no 'pairs'");
  expect_error("frame: link_4", "frame: link_44", "the robot has no frame 'link_44'");
  expect_error("ball: {sphere", "hand: {sphere", "two shapes have the name 'hand'");
  expect_error("to: [0, 0, 0.2]", "to: [0, 0, 0]", "the capsule has length 0");
  expect_error("floor: {half_space: {}}", "floor: {}", "the shape has no form");
  expect_error("{half_space: {}}", "{half_space: {}, sphere: {radius: 1}}", "a shape is one thing");
  expect_error("{half_space: {}}", "{half_space: {normal: [0, 0, 0]}}", "a direction of length 0");
}

constexpr std::string_view kBodies = R"(conddp: 1
robot: {urdf: robots/arm7.urdf}
collision:
  shapes:
    hand: {frame: tool, box: {size: [0.1, 0.2, 0.3], placement: {position: [0, 0, 0.1]}}}
    finger: {frame: tool, hull: {points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], radius: 0.01,
                                placement: {position: [0, 0, 0.2]}}}
  obstacles:
    post: {cylinder: {radius: 0.1, from: [1, 0, 0], to: [1, 0, 2]}}
    board: {box: {size: [0.4, 1, 0.02], placement: {position: [0.6, 0, 0.5], rpy: [0, 0, 1]}}}
    floor: {half_space: {}}
initial_state: {joints: {joint_2: 0.3}}
phases: [{knots: 2, dt: 0.1}]
costs: {clear: {residual: distance, pairs: all}}
)";

TEST(ShapePairs, PolytopesHaveTheCornersOfTheirBodies) {
  const Loaded loaded((std::string(kBodies)));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const CollisionSpec& collision = loaded.spec->collision;
  const Polytope hand = polytope_of(std::get<BoxSpec>(collision.shapes[0].form), 3);
  EXPECT_EQ(hand.frame, 3);
  ASSERT_EQ(hand.vertices.size(), 8u);
  for (const Vector3<double>& v : hand.vertices) {
    EXPECT_NEAR(std::abs(v.x), 0.05, 1e-15);
    EXPECT_NEAR(std::abs(v.y), 0.1, 1e-15);
    EXPECT_NEAR(std::abs(v.z - 0.1), 0.15, 1e-15);
  }
  // The prism touches the cylinder from outside.
  const Polytope post = polytope_of(std::get<CylinderSpec>(collision.obstacles[0].form), -1);
  for (double angle = 0; angle < 7; angle += 0.01) {
    double furthest = 0;
    for (const Vector3<double>& v : post.vertices)
      furthest = std::max(furthest, std::cos(angle) * (v.x - 1) + std::sin(angle) * v.y);
    EXPECT_GE(furthest, 0.1 - 1e-12);
    EXPECT_LE(furthest, 0.1005);
  }
  const Polytope finger = polytope_of(std::get<HullSpec>(collision.shapes[1].form), -1);
  EXPECT_EQ(finger.radius, 0.01);
  EXPECT_EQ(finger.vertices[1].x, 0.1);
  EXPECT_EQ(finger.vertices[1].z, 0.2);
}

TEST(ShapePairs, BodiesOverAHalfSpaceHaveARowForEachVertex) {
  const Loaded loaded((std::string(kBodies)));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& rows = loaded.built->problem->knot(0).model->costs()[0].residual;
  EXPECT_EQ(rows->size(), 2 + 8 + 2 + 3);
}

void expect_body_error(const char* from, const char* to, const std::string& message) {
  const Loaded loaded(replaced(kBodies, from, to));
  EXPECT_FALSE(loaded.built);
  EXPECT_NE(loaded.first_error().find(message), std::string::npos) << loaded.all();
}

TEST(ShapePairs, ImpossibleBodiesAreRejected) {
  expect_body_error("size: [0.1, 0.2, 0.3]", "size: [0.1, 0, 0.3]", "positive lengths");
  expect_body_error("to: [1, 0, 2]", "to: [1, 0, 0]", "the cylinder has length 0");
  expect_body_error("points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]], ", "",
                    "the hull has no points");
  expect_body_error("points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]", "points: [[0, 0]]",
                    "[x, y, z] in m");
  expect_body_error("points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]", "points: []",
                    "there is no point");
  expect_body_error("points: [[0, 0, 0],", "mesh: a.stl, points: [[0, 0, 0],",
                    "exclude each other");
  expect_body_error("points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]", "mesh: nothing.stl",
                    "nothing.stl");
  expect_body_error("points: [[0, 0, 0], [0.1, 0, 0], [0, 0.1, 0]]", "mesh: a.blend",
                    "only STL, OBJ, Collada and glTF files are read");
  expect_body_error("  shapes:", "  from: srdf\n  shapes:", "source of shapes");
}

constexpr std::string_view kFromUrdf = R"(conddp: 1
robot: {urdf: arm.urdf}
collision:
  from: urdf
  shapes: {hand: {frame: hand, sphere: {radius: 0.07}}}
  obstacles: {wall: {half_space: {normal: [-1, 0, 0], point: [2, 0, 0]}}}
initial_state: {joints: {a: 0.3}}
phases: [{knots: 2, dt: 0.1}]
costs: {clear: {residual: distance, pairs: obstacles}}
)";

/// An arm of two links: a box and a cylinder on the first, meshes on the second and on the hand.
std::string arm_urdf(const std::string& mesh) {
  const std::string inertial =
      "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>"
      "</inertial>";
  return "<robot name='arm'><link name='base'/><link name='upper'>" + inertial +
         "<collision><origin xyz='0.1 0 0' rpy='0 0 1.5707963267948966'/><geometry>"
         "<box size='0.2 0.04 0.06'/></geometry></collision>"
         "<collision><origin xyz='0 0 0.2' rpy='0 1.5707963267948966 0'/><geometry>"
         "<cylinder radius='0.03' length='0.4'/></geometry></collision></link>"
         "<link name='fore'>" +
         inertial + "<collision><geometry><mesh filename='" + mesh +
         "' scale='0.001 0.001 0.001'/></geometry></collision></link>"
         "<link name='hand'>" +
         inertial +
         "<collision><geometry><mesh filename='none.dae'/></geometry></collision></link>"
         "<joint name='a' type='revolute'><parent link='base'/><child link='upper'/>"
         "<axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
         "<joint name='b' type='revolute'><parent link='upper'/><child link='fore'/>"
         "<axis xyz='0 1 0'/><limit lower='-1' upper='1' effort='1' velocity='1'/></joint>"
         "<joint name='c' type='fixed'><parent link='fore'/><child link='hand'/></joint></robot>";
}

/// The problem of kFromUrdf in a folder, with an arm that names a mesh.
std::optional<ProblemSpec> read_from_urdf(const std::string& mesh, Diagnostics& out) {
  const TemporaryFolder folder;
  folder.write("arm.urdf", arm_urdf(mesh));
  folder.write("fore.obj", "v 100 0 0\nv 0 0 0\nv 0 100 0\nv 0 0 100\nv 20 20 20\nf 1 2 3\n");
  folder.write("empty.stl", "solid nothing");
  folder.write("fore.bin", std::string(36, '\0'));
  folder.write("fore.gltf", R"({"scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
"accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
"bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"uri": "fore.bin"}]})");
  folder.write("circle.gltf", R"({"scenes": [{"nodes": [0]}], "nodes": [{"children": [0]}]})");
  return read_problem_text(std::string(kFromUrdf), folder / "problem.yaml", {}, out);
}

TEST(UrdfShapes, LinksBringTheirShapesUnderTheirNames) {
  Diagnostics out;
  const auto spec = read_from_urdf("fore.obj", out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  Names names;
  for (const ShapeSpec& shape : spec->collision.shapes) names.push_back(shape.name.value);
  EXPECT_EQ(names, (Names{"hand", "upper", "upper/2", "fore"}));
  const auto& shapes = spec->collision.shapes;
  EXPECT_EQ(std::get<SphereSpec>(shapes[0].form).radius, 0.07);
  double reach = 0;
  for (const Vector3<double>& v : polytope_of(std::get<BoxSpec>(shapes[1].form), -1).vertices)
    reach = std::max(reach, v.y);
  EXPECT_NEAR(reach, 0.1, 1e-12);  // its long edge is turned towards y
  const auto& cylinder = std::get<CylinderSpec>(shapes[2].form);
  EXPECT_NEAR(cylinder.from.x, -0.2, 1e-12);
  EXPECT_NEAR(cylinder.to.x, 0.2, 1e-12);
  EXPECT_NEAR(cylinder.to.z, 0.2, 1e-12);
  const auto& hull = std::get<HullSpec>(shapes[3].form);
  EXPECT_EQ(hull.points.size(), 4u);  // without the vertex inside
  EXPECT_NEAR(hull.radius, 0.0005, 1e-15);
}

TEST(UrdfShapes, MeshesThatCannotBeReadAreNamed) {
  const auto error = [](const std::string& mesh) {
    Diagnostics out;
    EXPECT_FALSE(read_from_urdf(mesh, out));
    return format_diagnostics(out, false);
  };
  EXPECT_NE(error("gone.stl")
                .find("4:9: error: the collision mesh 'gone.stl' of the link 'fore' is "
                      "not found"),
            std::string::npos)
      << error("gone.stl");
  EXPECT_NE(error("empty.stl").find("the file has no vertex"), std::string::npos);
  EXPECT_NE(error("circle.gltf")
                .find("4:9: error: the collision mesh 'circle.gltf' of the link 'fore': "
                      "'circle.gltf': its nodes are not a tree"),
            std::string::npos)
      << error("circle.gltf");
}

TEST(UrdfShapes, FilesOfGltfAreDataOfTheProblem) {
  Diagnostics out;
  ASSERT_TRUE(read_from_urdf("fore.gltf", out)) << format_diagnostics(out, false);
  Names names;
  for (const InputFile& file : out.data_files())
    names.push_back(std::filesystem::path(file.file).filename());
  EXPECT_EQ(names, (Names{"fore.bin", "fore.gltf"}));
}

TEST(UrdfShapes, UnknownGeometriesAreNamedInAWarning) {
  const TemporaryFolder folder;
  std::string urdf = arm_urdf("fore.obj");
  urdf.replace(urdf.find("<mesh filename='none.dae'/>"), 27, "<capsule radius='1' length='1'/>");
  folder.write("arm.urdf", urdf);
  folder.write("fore.obj", "v 0 0 0\n");
  Diagnostics out;
  const std::string text =
      replaced(kFromUrdf, "  shapes: {hand: {frame: hand, sphere: {radius: 0.07}}}\n", "");
  const auto spec = read_problem_text(text, folder / "problem.yaml", {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  EXPECT_EQ(spec->collision.shapes.size(), 3u);
  EXPECT_NE(format_diagnostics(out, false)
                .find("4:9: warning: the collision shape 'capsule' of the link 'hand' is not read"),
            std::string::npos)
      << format_diagnostics(out, false);
}

TEST(UrdfShapes, ShapesOfSeveralRobotsHaveTheirPrefix) {
  const TemporaryFolder folder;
  folder.write("arm.urdf", arm_urdf("fore.obj"));
  folder.write("fore.obj", "v 0 0 0\n");
  Diagnostics out;
  const std::string text =
      replaced(replaced(replaced(kFromUrdf, "robot: {urdf: arm.urdf}",
                                 "robots: {left: {urdf: arm.urdf}, right: {urdf: arm.urdf}}"),
                        "{hand: {frame: hand, sphere: {radius: 0.07}}}",
                        "{left/hand: {frame: left/hand, sphere: {radius: 0.07}}, "
                        "right/hand: {frame: right/hand, sphere: {radius: 0.07}}}"),
               "joints: {a: 0.3}", "joints: {left/a: 0.3, right/a: 0.3}");
  const auto spec = read_problem_text(text, folder / "problem.yaml", {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  EXPECT_EQ(spec->collision.shapes.back().name.value, "right/fore");
  EXPECT_EQ(spec->collision.shapes.back().frame.value, "right/fore");
  EXPECT_EQ(spec->collision.shapes.size(), 8u);
}

TEST(UrdfShapes, MissingShapesAndTakenNamesAreErrors) {
  const auto error = [](const std::string& from, const std::string& to, const char* robot) {
    const TemporaryFolder folder;
    folder.write("arm.urdf", robot);
    Diagnostics out;
    EXPECT_FALSE(
        read_problem_text(replaced(kFromUrdf, from, to), folder / "problem.yaml", {}, out));
    return format_diagnostics(out, false);
  };
  constexpr const char *kHead = R"(<robot name="arm"><link name="base"/><link name="hand">
    <inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>)",
                       *kTail = R"(</link><joint name="a" type="revolute"><parent link="base"/>
    <child link="hand"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="1" effort="1" velocity="1"/></joint></robot>)";
  const std::string bare = std::string(kHead) + kTail;
  const std::string ball = std::string(kHead) +
                           "<collision><geometry><sphere radius='1'/></geometry></collision>" +
                           kTail;
  EXPECT_NE(error("conddp: 1", "conddp: 1", bare.c_str())
                .find("4:9: error: the URDF has no collision shape"),
            std::string::npos);
  const std::string taken =
      error("shapes: {hand: {frame: hand, sphere: {radius: 0.07}}}\n  obstacles: {wall",
            "obstacles: {hand", ball.c_str());
  EXPECT_NE(taken.find("a shape of the URDF and an obstacle have the name 'hand'"),
            std::string::npos)
      << taken;
}

TEST(ShapePairs, NeedRobotsAndShapes) {
  const Loaded closed(std::string(kPendulum) + "collision: {obstacles: {f: {half_space: {}}}}\n");
  EXPECT_NE(closed.first_error().find("a closed-form system has no links"), std::string::npos);
  const Loaded none(
      replaced(kCartpole, "phases:", "costs: {c: {residual: distance, pairs: self}}\nphases:"));
  EXPECT_NE(none.first_error().find("the cost 'c' has no pair of shapes"), std::string::npos)
      << none.all();
}

TEST(Distance, CostsHalfTheSquaredMarginDeficit) {
  const Loaded loaded(replaced(kArm, "pairs: all", "pairs: [[hand, floor]], margin: 2, weight: 3"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& problem = *loaded.built->problem;
  const KnotModel& model = *problem.knot(0).model;
  KnotWorkspace<double> work(model);
  const Trajectory& guess = loaded.built->guess;
  model.evaluate(
      KnotInput<double>{guess.x(0).data(), guess.u(0).data(), problem.knot(0).parameters, 0.1, 1.0},
      work);
  const Plant& plant = loaded.built->plant;
  const int tool = *plant.robot().find_frame("tool");
  const double height =
      placement_in_state(*plant.multibody(), problem.initial_state(), tool).p.z - 0.05;
  EXPECT_NEAR(work.cost, 0.5 * 3 * (2 - height) * (2 - height), 1e-12);
}

TEST(Joints, CostJointsMayBePatterns) {
  const auto rows = [](const char* joints) {
    const Loaded loaded(replaced(kArm, "residual: distance, pairs: all",
                                 std::string("residual: joint_position, joints: ") + joints));
    EXPECT_TRUE(loaded.built) << loaded.all();
    return loaded.built ? loaded.built->problem->knot(0).model->costs()[0].residual->size() : 0;
  };
  EXPECT_EQ(rows("'joint_*'"), 7);
  EXPECT_EQ(rows("[joint_3, 'joint_*']"), 7);
  EXPECT_EQ(rows("[joint_3, 'joint_5*']"), 2);
  expect_error("residual: distance, pairs: all", "residual: joint_position, joints: ['L*']",
               "'L*' fits none of the joints");
}

}  // namespace
}  // namespace conddp
