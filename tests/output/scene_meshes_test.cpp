// Meshes of a page: each file once, simplified where they are too large together.
#include "output/scene/scene_meshes.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A plane of count x count squares as an OBJ file.
std::string plane(int count) {
  std::string text;
  for (int i = 0; i <= count; ++i)
    for (int j = 0; j <= count; ++j) text += fmt::format("v {} {} 0\n", i, j);
  const int row = count + 1;
  for (int i = 0; i < count; ++i)
    for (int j = 1; j <= count; ++j)
      text += fmt::format("f {} {} {} {}\n", i * row + j, i * row + j + 1, (i + 1) * row + j + 1,
                          (i + 1) * row + j);
  return text;
}

/// Number of bytes that base64 holds.
std::size_t bytes_of(const OrderedJson& text) {
  const std::string value = text.get<std::string>();
  return value.size() / 4 * 3 - std::count(value.begin(), value.end(), '=');
}

TEST(SceneMeshes, FilesStandOnce) {
  const TemporaryFolder folder;
  folder.write("a.obj", plane(2));
  folder.write("empty.obj", "v 0 0 0\n");
  SceneMeshes meshes;
  std::string why;
  EXPECT_EQ(meshes.add(folder / "a.obj", why), 0u);
  EXPECT_EQ(meshes.add(folder / "a.obj", why), 0u);
  EXPECT_FALSE(meshes.add(folder / "empty.obj", why));
  EXPECT_EQ(why, "no surface inside");
  EXPECT_FALSE(meshes.add({}, why));
  EXPECT_EQ(why, "mesh not found");
  folder.write("a.gltf", "{}");
  EXPECT_FALSE(meshes.add(folder / "a.gltf", why));
  EXPECT_TRUE(why.starts_with("mesh not readable: 'a.gltf': it is not glTF")) << why;
  const OrderedJson json = meshes.json();
  ASSERT_EQ(json.size(), 1u);
  const OrderedJson& part = json[0][0];
  EXPECT_EQ(bytes_of(part["positions"]), 9u * 3 * 2);
  EXPECT_EQ(bytes_of(part["triangles"]), 8u * 3 * 2);
  EXPECT_NEAR(part["step"].get<double>() * 65535, 2, 1e-12);
}

TEST(SceneMeshes, LargeMeshesAreSimplified) {
  const TemporaryFolder folder;
  folder.write("large.obj", plane(300));
  folder.write("small.obj", plane(3));
  SceneMeshes meshes;
  std::string why;
  ASSERT_TRUE(meshes.add(folder / "large.obj", why));
  ASSERT_TRUE(meshes.add(folder / "small.obj", why));
  const OrderedJson json = meshes.json();
  // 90 601 vertices are too many for indices of 16 bits; simplified ones are not.
  EXPECT_LE(bytes_of(json[0][0]["positions"]), 65536u * 3 * 2);
  const std::size_t triangles = bytes_of(json[0][0]["triangles"]) / (3 * 2);
  EXPECT_LE(triangles, SceneMeshes::kMostTriangles);
  EXPECT_GT(triangles, SceneMeshes::kMostTriangles / 10);
  EXPECT_EQ(bytes_of(json[1][0]["triangles"]), 18u * 3 * 2);
}

TEST(SceneMeshes, ManyVerticesHaveWideIndices) {
  const TemporaryFolder folder;
  std::string text = plane(200);
  for (int i = 0; i < 30000; ++i) text += fmt::format("v {} 0 1\n", i * 0.006);
  folder.write("many.obj", text);
  SceneMeshes meshes;
  std::string why;
  ASSERT_TRUE(meshes.add(folder / "many.obj", why));
  const OrderedJson part = meshes.json()[0][0];
  EXPECT_GT(bytes_of(part["positions"]), 65536u * 3 * 2);
  EXPECT_EQ(bytes_of(part["triangles"]), 200u * 200 * 2 * 3 * 4);
}

}  // namespace
}  // namespace conddp
