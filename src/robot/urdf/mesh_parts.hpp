#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "spatial/vector3.hpp"

namespace conddp {

/// Triangles of one color.
struct MeshPart {
  std::vector<Vector3<double>> vertices;                ///< finite
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of vertices
  std::optional<std::array<double, 4>> color = {};      ///< red, green, blue, alpha in [0, 1]
};

/// A box around points, parallel to the axes.
struct Bounds {
  explicit Bounds(const std::vector<Vector3<double>>& points);

  Vector3<double> low, high;
  /// Longest edge; 0 without points.
  double longest() const;
};

/// Reason why a mesh cannot be read, a clause about its file.
class MeshDefect : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Returns the bytes of a file that a mesh file names, or throws MeshDefect.
using ReadSideFile = std::function<std::string(const std::string& name)>;

/// The surfaces in a mesh file of a kind as mesh_kind() returns it: in the file's own unit, of
/// Collada and glTF in m. Empty for bytes that hold another kind. Facets with vertices that are
/// missing or not finite are left out. Throws MeshDefect for glTF that is damaged or unsupported.
std::vector<MeshPart> mesh_parts(std::string_view bytes, const std::string& kind,
                                 const ReadSideFile& read);

/// The surfaces in a Collada document, each instance at its place in the scene. As in RViz, the
/// axis that the document calls up is ignored.
std::vector<MeshPart> collada_parts(std::string_view xml);

/// The surfaces in a glTF 2.0 document, text or binary, each instance at its place in the scene,
/// with the base colors of their materials. As in RViz and Drake, the axis y of the document, which
/// points up, becomes z. Throws MeshDefect, also for strips, sparse or compressed data.
std::vector<MeshPart> gltf_parts(std::string_view bytes, const ReadSideFile& read);

/// A surface with at most `most` triangles: vertices in the same cell of a grid, which has at most
/// 65535 cells along the largest edge of the bounding box, become their mean.
MeshPart simplified(const MeshPart& part, std::size_t most);

}  // namespace conddp
