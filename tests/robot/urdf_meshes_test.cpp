#include "robot/urdf/urdf_meshes.hpp"

#include <gtest/gtest.h>

#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

TEST(UrdfMeshes, FilesLieBesideTheUrdfAndInPackages) {
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
  EXPECT_EQ(mesh_kind("a.DAE"), "dae");
  EXPECT_EQ(mesh_kind("a.GLB"), "glb");
  EXPECT_EQ(mesh_kind("a.gltf"), "gltf");
  EXPECT_EQ(mesh_kind("a.blend"), "");
}

}  // namespace
}  // namespace conddp
