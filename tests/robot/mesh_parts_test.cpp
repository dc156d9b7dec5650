// Surfaces in mesh files, and their simplification.
#include "robot/urdf/mesh_parts.hpp"

#include <cmath>
#include <cstring>
#include <limits>

#include <gtest/gtest.h>

namespace conddp {
namespace {

std::vector<MeshPart> parts_in(const std::string& bytes, const std::string& kind) {
  return mesh_parts(bytes, kind, [](const std::string&) { return std::string(); });
}

/// A binary STL with one facet of given coordinates, which says that it has `facets`.
std::string binary_stl(const std::vector<float>& coordinates, std::uint32_t facets = 1) {
  std::string bytes(84, ' ');
  std::memcpy(bytes.data() + 80, &facets, sizeof facets);
  bytes.append(12, '\0');
  bytes.append(reinterpret_cast<const char*>(coordinates.data()), 9 * sizeof(float));
  return bytes.append(2, '\0');
}

/// A document whose scene has these nodes. The geometry `g` has the corners of a unit square.
std::string collada(const std::string& nodes, const std::string& faces, const std::string& meter) {
  return R"(<COLLADA><asset><unit meter=")" + meter + R"("/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique><lambert><diffuse>
<color>0.2 0.4 0.6 1</color></diffuse></lambert></technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="blue"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array count="12">0 0 0 1 0 0 1 1 0 0 1 0</float_array>
<technique_common><accessor stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>)" +
         faces + R"(</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="scene">)" +
         nodes + R"(</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>)";
}

const std::string kSquare =
    R"(<polylist material="m" count="1"><input semantic="VERTEX" source="#v" offset="0"/>
<input semantic="NORMAL" source="#n" offset="1"/><vcount>4</vcount><p>0 9 1 9 2 9 3 9</p></polylist>)";
const std::string kInstance =
    R"(<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="m" target="#blue"/></technique_common></bind_material></instance_geometry>)";

TEST(MeshParts, FormatsGiveTheirFacets) {
  const std::vector<float> numbers = {0, 0, 0, 1, 0, 0.5, 0, 2, -3};
  const std::string ascii =
      "solid a\nfacet normal 0 0 1\nouter loop\n vertex 0 0 0\n vertex 1 0 5e-1\n vertex 0 2 -3\n"
      "endloop\nendfacet\nendsolid a\n";
  const std::string obj = "# three\nv 0 0 0\nv 1 0 0.5\nv 0 2 -3 1\nvn 9 9 9\nf 1/1 -2/2 3/3\n";
  for (const auto& [bytes, kind] :
       {std::pair{binary_stl(numbers), "stl"}, std::pair{ascii, "stl"}, std::pair{obj, "obj"}}) {
    const auto parts = parts_in(bytes, kind);
    ASSERT_EQ(parts.size(), 1u) << kind;
    ASSERT_EQ(parts[0].triangles.size(), 1u) << kind;
    for (int i = 0; i < 3; ++i)
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_EQ(parts[0].vertices[parts[0].triangles[0][i]][axis], numbers[3 * i + axis]) << kind;
  }
  EXPECT_EQ(parts_in("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "obj")[0].triangles.size(),
            2u);
}

TEST(MeshParts, DamagedFilesLoseTheirFacets) {
  const std::vector<float> numbers = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_TRUE(parts_in(binary_stl(numbers, 2), "stl").empty()) << "the second facet is missing";
  EXPECT_TRUE(parts_in(binary_stl(numbers, 0xffffffff), "stl").empty());
  EXPECT_TRUE(parts_in("", "stl").empty());
  EXPECT_TRUE(parts_in("version 1\nsize 123456\n", "obj").empty());
  EXPECT_TRUE(parts_in("version 1\nsize 123456\n", "dae").empty());
  const auto parts = parts_in("v 1 2\nv nan 0 0\nv 1 2 3\nv x y z\nf 1 2 3\nf 3 3 9\n", "obj");
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].vertices.size(), 1u);
  EXPECT_TRUE(parts[0].triangles.empty());
  std::vector<float> infinite = numbers;
  infinite[4] = std::numeric_limits<float>::infinity();
  EXPECT_TRUE(parts_in(binary_stl(infinite), "stl").empty());
}

TEST(MeshParts, ColladaPlacesInstancesInMeters) {
  const std::string nodes =
      "<node><translate>100 0 0</translate><rotate>0 0 1 90</rotate><node>"
      "<matrix>2 0 0 0 0 3 0 0 0 0 1 5 0 0 0 1</matrix>" +
      kInstance + "</node></node><node>" + kInstance + "</node>";
  const auto parts = parts_in(collada(nodes, kSquare, "0.01"), "dae");
  ASSERT_EQ(parts.size(), 2u);
  ASSERT_EQ(parts[0].triangles.size(), 2u);
  // The corner (1, 1, 0) becomes (2, 3, 5), turned (−3, 2, 5), moved (97, 2, 5), in centimeters.
  const Vector3<double> corner = parts[0].vertices[2];
  EXPECT_NEAR(corner.x, 0.97, 1e-12);
  EXPECT_NEAR(corner.y, 0.02, 1e-12);
  EXPECT_NEAR(corner.z, 0.05, 1e-12);
  EXPECT_EQ(parts[1].vertices[1].x, 0.01);
  ASSERT_TRUE(parts[0].color);
  EXPECT_EQ(*parts[0].color, (std::array<double, 4>{0.2, 0.4, 0.6, 1}));
}

TEST(MeshParts, HostileColladaEnds) {
  // Nodes that contain themselves, indices without vertices, and counts without corners.
  const std::string circle = "<node id=\"n\">" + kInstance + "<instance_node url=\"#n\"/></node>";
  EXPECT_LE(parts_in(collada(circle, kSquare, "1"), "dae").size(), 100u);
  const std::string bare =
      "<node id=\"n\"><instance_node url=\"#n\"/><instance_node url=\"#n\"/></node>";
  EXPECT_TRUE(parts_in(collada(bare, kSquare, "1"), "dae").empty());
  const std::string input = "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/>";
  for (const std::string& faces : std::vector<std::string>{
           "<triangles>" + input + "<p>0 1 99</p></triangles>",
           "<polylist>" + input + "<vcount>3 4 -1</vcount><p>0 1</p></polylist>",
           "<triangles>" + input + "<p></p></triangles>", "<polygons>" + input + "</polygons>",
           "<triangles><input semantic=\"VERTEX\" source=\"#v\" offset=\"-7\"/><p>0 1 "
           "2</p></triangles>"})
    EXPECT_TRUE(parts_in(collada("<node>" + kInstance + "</node>", faces, "1"), "dae").empty())
        << faces;
}

/// The unit sphere with `count` meridians.
MeshPart sphere(std::uint32_t count) {
  MeshPart part;
  for (std::uint32_t i = 0; i <= count; ++i)
    for (std::uint32_t j = 0; j < count; ++j) {
      const double a = M_PI * i / count, b = 2 * M_PI * j / count;
      part.vertices.push_back({std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)});
      if (i == count) continue;
      const std::uint32_t p = i * count + j, q = i * count + (j + 1) % count;
      part.triangles.push_back({p, q, q + count});
      part.triangles.push_back({p, q + count, p + count});
    }
  return part;
}

TEST(MeshParts, SimplifiedSurfacesStayNear) {
  const MeshPart fine = sphere(300);
  for (const std::size_t most : {20000u, 2000u, 200u}) {
    const MeshPart coarse = simplified(fine, most);
    EXPECT_LE(coarse.triangles.size(), most);
    EXPECT_GE(coarse.triangles.size(), most / 5);
    double radius = 1;
    for (const Vector3<double>& p : coarse.vertices)
      radius = std::min(radius, std::sqrt(squared_norm(p)));
    EXPECT_GT(radius, 1 - 20.0 / static_cast<double>(most));
  }
  EXPECT_EQ(simplified(sphere(8), 1000).triangles.size(), 2u * 8 * 8 - 2 * 8);
}

}  // namespace
}  // namespace conddp
