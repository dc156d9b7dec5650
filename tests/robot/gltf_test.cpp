// glTF meshes: their triangles, places and colors, and documents that are damaged on purpose.
#include <cstring>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/text/base64.hpp"
#include "robot/urdf/mesh_file.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

using nlohmann::json;

template <class Number>
std::string bytes_of(const std::vector<Number>& numbers) {
  std::string bytes(numbers.size() * sizeof(Number), '\0');
  std::memcpy(bytes.data(), numbers.data(), bytes.size());
  return bytes;
}

/// Four points, and the indices of two triangles in 16 bits.
std::string square_bytes() {
  return bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 3}) +
         bytes_of<std::uint16_t>({0, 1, 2, 0, 2, 3});
}

/// A document whose only node shows the square; its buffer lies at `uri`.
json gltf_square(const std::string& uri) {
  json document = json::parse(R"({
"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
"accessors": [
  {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
  {"bufferView": 0, "byteOffset": 48, "componentType": 5123, "count": 6, "type": "SCALAR"}],
"bufferViews": [{"buffer": 0, "byteLength": 60}], "buffers": [{"byteLength": 60}]})");
  if (!uri.empty()) document["buffers"][0]["uri"] = uri;
  return document;
}

const std::string kSquareUri = "data:application/octet-stream;base64," + base64(square_bytes());

std::string glb_chunk(std::string contents, const char* kind, char padding) {
  while (contents.size() % 4 != 0) contents += padding;
  return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(contents.size())}) +
         std::string(kind, 4) + contents;
}

std::string glb(const json& document, const std::string& binary) {
  const std::string chunks =
      glb_chunk(document.dump(), "JSON", ' ') + glb_chunk(binary, "BIN\0", '\0');
  return "glTF" + bytes_of<std::uint32_t>({2, static_cast<std::uint32_t>(12 + chunks.size())}) +
         chunks;
}

std::vector<MeshPart> gltf_square_parts(const json& document) {
  return gltf_parts(document.dump(), [](const std::string&) { return std::string(); });
}

std::string gltf_defect(const std::string& bytes) {
  try {
    gltf_parts(bytes, [](const std::string&) { return std::string(); });
  } catch (const MeshDefect& defect) {
    return defect.what();
  }
  return {};
}
std::string gltf_defect(const json& document) { return gltf_defect(document.dump()); }

void expect_point(const Vector3<double>& point, const Vector3<double>& expected) {
  for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(point[axis], expected[axis], 1e-12) << axis;
}

void expect_square(const std::vector<MeshPart>& parts) {
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}, {0, 2, 3}}));
  ASSERT_EQ(parts[0].vertices.size(), 4u);
  expect_point(parts[0].vertices[3], {0, -3, 2});
  EXPECT_FALSE(parts[0].color);
}

TEST(Gltf, BuffersOfAllKindsGiveTheSquare) {
  const TemporaryFolder folder;
  folder.write("inside.glb", glb(gltf_square(""), square_bytes()));
  folder.write("inside.gltf", gltf_square(kSquareUri).dump());
  folder.write("a square.bin", square_bytes());
  folder.write("beside.gltf", gltf_square("a%20square.bin").dump());
  for (const char* name : {"inside.glb", "inside.gltf", "beside.gltf"}) {
    const MeshFile mesh = read_mesh_file(folder / name);
    EXPECT_EQ(mesh.defect, "") << name;
    expect_square(mesh.parts);
    EXPECT_EQ(mesh.sources.size(), name[0] == 'b' ? 2u : 1u) << name;
  }
}

TEST(Gltf, NodesPlaceTheirChildren) {
  json document = gltf_square(kSquareUri);
  // The parent moves and turns about z by 90 degrees, the child stretches y, both y up.
  document["nodes"] = json::parse(R"([
{"children": [1], "translation": [10, 20, 30], "rotation": [0, 0, 0.7071067811865476, 0.7071067811865476]},
{"mesh": 0, "scale": [1, 3, 1]}])");
  // (1, 2, 0) → (1, 6, 0) → (−6, 1, 0) → (4, 21, 30), and y becomes z.
  expect_point(gltf_square_parts(document).at(0).vertices[2], {4, -30, 21});
  document["nodes"][0] = json::parse(
      R"({"children": [1], "matrix": [0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, 10, 20, 30, 1]})");
  expect_point(gltf_square_parts(document).at(0).vertices[2], {4, -30, 21});
}

TEST(Gltf, TrianglesNeedNoIndices) {
  json document = gltf_square(kSquareUri);
  document["meshes"][0]["primitives"][0].erase("indices");
  const auto parts = gltf_square_parts(document);
  ASSERT_EQ(parts.size(), 1u);
  EXPECT_EQ(parts[0].triangles, (std::vector<std::array<std::uint32_t, 3>>{{0, 1, 2}}));
}

TEST(Gltf, InterleavedVerticesAndBytesAreRead) {
  json document =
      gltf_square("data:;base64," + base64(bytes_of<float>({9, 0, 0, 0, 9, 1, 0, 0, 9, 0, 1, 0}) +
                                           std::string("\2\1\0", 3)));
  document["bufferViews"] = json::parse(R"([{"buffer": 0, "byteOffset": 4, "byteLength": 44,
"byteStride": 16}, {"buffer": 0, "byteOffset": 48, "byteLength": 3}])");
  document["accessors"] = json::parse(R"([
{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
{"bufferView": 1, "componentType": 5121, "count": 3, "type": "SCALAR"}])");
  const auto parts = gltf_square_parts(document);
  ASSERT_EQ(parts.size(), 1u);
  expect_point(parts[0].vertices[1], {1, 0, 0});
  expect_point(parts[0].vertices[2], {0, 0, 1});
  EXPECT_EQ(parts[0].triangles, (std::vector<std::array<std::uint32_t, 3>>{{2, 1, 0}}));
}

TEST(Gltf, BaseColorsBecomeSrgb) {
  json document = gltf_square(kSquareUri);
  document["meshes"][0]["primitives"][0]["material"] = 0;
  const auto color = [&](const char* material) {
    document["materials"] = json::array({json::parse(material)});
    return gltf_square_parts(document).at(0).color;
  };
  auto found = color(R"({"pbrMetallicRoughness": {"baseColorFactor": [0.5, 0, 1, 0.25]}})");
  ASSERT_TRUE(found);
  EXPECT_NEAR((*found)[0], 0.7353569830524495, 1e-12);  // three.js, Color.convertLinearToSRGB
  EXPECT_EQ((*found)[1], 0);
  EXPECT_NEAR((*found)[2], 1, 1e-12);
  EXPECT_EQ((*found)[3], 1) << "opaque unless the material blends";
  found = color(
      R"({"alphaMode": "BLEND", "pbrMetallicRoughness": {"baseColorFactor": [0.5, 0, 1, 0.25]}})");
  EXPECT_EQ((*found)[3], 0.25);
  found = color("{}");
  for (const double part : *found) EXPECT_NEAR(part, 1, 1e-12);
  EXPECT_EQ(color(R"({"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}})"), std::nullopt);
}

TEST(Gltf, UnsupportedDataAreNamed) {
  const auto defect = [](const char* patch) {
    json document = gltf_square(kSquareUri);
    document.merge_patch(json::parse(patch));
    return gltf_defect(document);
  };
  EXPECT_EQ(defect(R"({"extensionsRequired": ["KHR_materials_unlit"]})"), "");
  EXPECT_EQ(defect(R"({"extensionsRequired": ["KHR_draco_mesh_compression"]})"),
            "it needs the extension 'KHR_draco_mesh_compression', which is not read");
  EXPECT_EQ(defect(R"({"meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "mode": 5}]}]})"),
            "strips and fans of triangles are not read");
  EXPECT_EQ(defect(R"({"accessors": [{"componentType": 5126, "count": 4, "type": "VEC3"}]})"),
            "an accessor has no data");
  EXPECT_EQ(
      defect(R"({"accessors": [{"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3",
"sparse": {}}]})"),
      "sparse accessors are not read");
  EXPECT_EQ(
      defect(
          R"({"accessors": [{"bufferView": 0, "componentType": 5122, "count": 4, "type": "VEC3"}]})"),
      "its positions are not three floats each");
  EXPECT_EQ(defect(R"({"buffers": [{"uri": "data:;base64,***"}]})"),
            "the data of a buffer are not base64");
  EXPECT_TRUE(gltf_square_parts([] {
                json document = gltf_square(kSquareUri);
                document["meshes"][0]["primitives"][0]["mode"] = 1;
                return document;
              }())
                  .empty())
      << "lines have no surface";
}

TEST(Gltf, HostileDocumentsEnd) {
  const auto defect = [](const char* patch) {
    json document = gltf_square(kSquareUri);
    document.merge_patch(json::parse(patch));
    return gltf_defect(document);
  };
  for (const char* circle :
       {R"({"nodes": [{"children": [0]}]})", R"({"nodes": [{"children": [1, 1]}, {}]})",
        R"({"nodes": [{"children": [1]}, {"children": [0]}]})"})
    EXPECT_EQ(defect(circle), "its nodes are not a tree") << circle;
  for (const char* far :
       {R"("count": 6)", R"("count": 4294967295)", R"("count": 4, "byteOffset": 16)",
        R"("count": 4, "byteOffset": 4294967295)"})
    EXPECT_EQ(
        defect((std::string(
                    R"({"accessors": [{"bufferView": 0, "componentType": 5126, "type": "VEC3", )") +
                far + "}]}")
                   .c_str()),
        "its data end too early")
        << far;
  for (const char* wrong : {"-1", "0.5", "1e300", "99999999999999999999", "\"4\"", "null"})
    EXPECT_NE(
        defect((std::string(R"({"bufferViews": [{"buffer": 0, "byteLength": )") + wrong + "}]}")
                   .c_str()),
        "")
        << wrong;
  for (const char* missing :
       {R"({"nodes": [{"mesh": 1}]})", R"({"nodes": [{"children": [7]}]})", R"({"scene": 3})",
        R"({"nodes": [{"mesh": 0, "matrix": [1]}]})", R"({"accessors": null})",
        R"({"scenes": {"nodes": 7}})", R"({"nodes": [{"children": [-1]}]})"})
    EXPECT_TRUE(defect(missing).starts_with("it is not glTF (")) << missing << defect(missing);
}

TEST(Gltf, CornersOutOfRangeLoseTheirTriangle) {
  json document =
      gltf_square("data:;base64," + base64(bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 3}) +
                                           bytes_of<std::uint16_t>({0, 1, 2, 0, 2, 4})));
  EXPECT_EQ(gltf_square_parts(document).at(0).triangles.size(), 1u);
}

TEST(Gltf, ManyInstancesAreTooMany) {
  // Eleven thousand points, shown by three thousand nodes.
  json document = gltf_square("data:;base64," + base64(std::string(132'000, '\0')));
  document["bufferViews"][0]["byteLength"] = 132'000;
  document["accessors"][0]["count"] = 11'000;
  json& nodes = document["nodes"] = json::array();
  json& shown = document["scenes"][0]["nodes"] = json::array();
  for (int i = 0; i < 3'000; ++i) {
    nodes.push_back({{"mesh", 0}});
    shown.push_back(i);
  }
  EXPECT_EQ(gltf_defect(document), "it has too many vertices");
}

TEST(Gltf, EveryTruncationIsADefect) {
  const std::string good = glb(gltf_square(""), square_bytes());
  for (std::size_t size = 0; size < good.size(); ++size)
    EXPECT_NE(gltf_defect(good.substr(0, size)), "") << size;
  std::string other = good;
  other[4] = 1;
  EXPECT_EQ(gltf_defect(other), "only version 2 of glTF is read");
  EXPECT_NE(gltf_defect(std::string(1'000'000, '[')), "");
}

TEST(Gltf, MissingSideFileIsNamed) {
  const TemporaryFolder folder;
  folder.write("a.gltf", gltf_square("none.bin").dump());
  const MeshFile mesh = read_mesh_file(folder / "a.gltf");
  EXPECT_TRUE(mesh.defect.starts_with("'a.gltf': '")) << mesh.defect;
  EXPECT_NE(mesh.defect.find("none.bin' does not exist"), std::string::npos) << mesh.defect;
}

}  // namespace
}  // namespace conddp
