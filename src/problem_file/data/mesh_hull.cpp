#include "problem_file/data/mesh_hull.hpp"

#include <fmt/format.h>

#include "base/files/check_sums.hpp"
#include "robot/urdf/mesh_file.hpp"
#include "robot/urdf/urdf_meshes.hpp"
#include "spatial/convex_distance.hpp"

namespace conddp {

HullSpec mesh_hull(const std::filesystem::path& file, const Vector3<double>& scale,
                   std::string& defect, Diagnostics& out) {
  constexpr double kTolerance = 0.005;
  if (mesh_kind(file.string()).empty())
    return defect = fmt::format("only {} files are read", kMeshFormats), HullSpec();
  const MeshFile mesh = read_mesh_file(file);
  defect = mesh.defect;
  if (!defect.empty()) return {};
  std::vector<Vector3<double>> points;
  for (const MeshPart& part : mesh.parts)
    points.insert(points.end(), part.vertices.begin(), part.vertices.end());
  if (points.empty()) return defect = "the file has no vertex", HullSpec();
  for (Vector3<double>& point : points)
    for (int axis = 0; axis < 3; ++axis) point[axis] *= scale[axis];
  for (const auto& [name, bytes] : mesh.sources) out.add_data_file({name.string(), sha256(bytes)});
  const double tolerance = kTolerance * Bounds(points).longest();
  return {hull_points(points, tolerance), tolerance};
}

}  // namespace conddp
