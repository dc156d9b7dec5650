#include "robot/urdf/urdf_meshes.hpp"

#include <cstdint>
#include <cstring>

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A binary STL with one facet of given coordinates, which says that it has `facets`.
std::string binary_stl(const std::vector<float>& coordinates, std::uint32_t facets = 1) {
  std::string bytes(84, ' ');
  std::memcpy(bytes.data() + 80, &facets, sizeof facets);
  bytes.append(12, '\0');
  bytes.append(reinterpret_cast<const char*>(coordinates.data()), 9 * sizeof(float));
  return bytes.append(2, '\0');
}

TEST(UrdfMeshes, FormatsGiveTheirVertices) {
  const std::vector<float> numbers = {0, 0, 0, 1, 0, 0.5, 0, 2, -3};
  const std::string ascii =
      "solid a\nfacet normal 0 0 1\nouter loop\n vertex 0 0 0\n vertex 1 0 5e-1\n vertex 0 2 -3\n"
      "endloop\nendfacet\nendsolid a\n";
  const std::string obj = "# three\nv 0 0 0\nv 1 0 0.5\nv 0 2 -3 1\nvn 9 9 9\nf 1/1 2/2 3/3\n";
  for (const auto& [bytes, kind] :
       {std::pair{binary_stl(numbers), "stl"}, std::pair{ascii, "stl"}, std::pair{obj, "obj"}}) {
    const auto points = mesh_points(bytes, kind);
    ASSERT_EQ(points.size(), 3u) << kind;
    for (int i = 0; i < 3; ++i)
      for (int axis = 0; axis < 3; ++axis)
        EXPECT_EQ(points[i][axis], numbers[3 * i + axis]) << kind << ' ' << i;
  }
}

TEST(UrdfMeshes, DamagedMeshesHaveFewerVertices) {
  const std::vector<float> numbers = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  EXPECT_TRUE(mesh_points(binary_stl(numbers, 2), "stl").empty()) << "the second facet is missing";
  EXPECT_TRUE(mesh_points(binary_stl(numbers, 0xffffffff), "stl").empty());
  EXPECT_TRUE(mesh_points("", "stl").empty());
  EXPECT_TRUE(mesh_points("version 1\nsize 123456\n", "obj").empty());
  EXPECT_EQ(mesh_points("v 1 2\nv nan 0 0\nv 1 2 3\nv x y z\n", "obj").size(), 1u);
  std::vector<float> infinite = numbers;
  infinite[4] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(mesh_points(binary_stl(infinite), "stl").size(), 2u);
}

TEST(UrdfMeshes, FilesAreFoundBesideTheUrdfAndInPackages) {
  const TemporaryFolder folder;
  std::filesystem::create_directories(folder / "arm/meshes");
  std::filesystem::create_directories(folder / "arm/urdf");
  folder.write("arm/meshes/a.STL", "");
  const std::filesystem::path urdf = folder / "arm/urdf/arm.urdf";
  EXPECT_EQ(find_mesh("../meshes/a.STL", urdf), folder / "arm/urdf/../meshes/a.STL");
  EXPECT_TRUE(std::filesystem::equivalent(find_mesh("package://arm/meshes/a.STL", urdf),
                                          folder / "arm/meshes/a.STL"));
  EXPECT_TRUE(find_mesh("package://arm/meshes/b.stl", urdf).empty());
  EXPECT_TRUE(find_mesh("package://", urdf).empty());
  EXPECT_EQ(mesh_kind("package://arm/meshes/a.STL"), "stl");
  EXPECT_EQ(mesh_kind("a.dae"), "");
}

}  // namespace
}  // namespace conddp
