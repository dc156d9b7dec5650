#pragma once

#include <array>
#include <cstdint>
#include <optional>
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

/// The surfaces in a mesh file of a kind as mesh_kind() returns it: in the file's own unit, of
/// Collada in m. Empty for bytes that hold another kind. Facets with vertices that are missing or
/// not finite are left out.
std::vector<MeshPart> mesh_parts(std::string_view bytes, const std::string& kind);

/// The surfaces in a Collada document, each instance at its place in the scene. As in RViz, the
/// axis that the document calls up is ignored.
std::vector<MeshPart> collada_parts(std::string_view xml);

/// A surface with at most `most` triangles: vertices in the same cell of a grid, which has at most
/// 65535 cells along the largest edge of the bounding box, become their mean.
MeshPart simplified(const MeshPart& part, std::size_t most);

}  // namespace conddp
