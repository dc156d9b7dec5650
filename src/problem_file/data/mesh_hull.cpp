#include "problem_file/data/mesh_hull.hpp"

#include "base/files/check_sums.hpp"
#include "base/files/text_file.hpp"
#include "robot/urdf/mesh_parts.hpp"
#include "robot/urdf/urdf_meshes.hpp"
#include "spatial/convex_distance.hpp"

namespace conddp {

HullSpec mesh_hull(const std::filesystem::path& file, const Vector3<double>& scale,
                   std::string& defect, Diagnostics& out) {
  constexpr double kTolerance = 0.005;
  const std::string kind = mesh_kind(file.string());
  if (kind.empty()) return defect = "only STL, OBJ and Collada files are read", HullSpec();
  const TextFile mesh = read_text_file(file, kMaxDataBytes);
  defect = mesh.defect;
  if (!defect.empty()) return {};
  std::vector<Vector3<double>> points;
  for (const MeshPart& part : mesh_parts(mesh.text, kind))
    points.insert(points.end(), part.vertices.begin(), part.vertices.end());
  if (points.empty()) return defect = "the file has no vertex", HullSpec();
  for (Vector3<double>& point : points)
    for (int axis = 0; axis < 3; ++axis) point[axis] *= scale[axis];
  out.add_data_file({file.string(), sha256(mesh.text)});
  const double tolerance = kTolerance * Bounds(points).longest();
  return {hull_points(points, tolerance), tolerance};
}

}  // namespace conddp
