#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "spatial/inertia.hpp"

namespace conddp {

enum class ShapeKind { box, cylinder, sphere, mesh, unknown };

/// One shape of a link.
struct VisualShape {
  ShapeKind kind = ShapeKind::unknown;
  SE3<double> placement = SE3<double>::identity();  ///< in the link's frame
  /// m: edges of a box; radius and length of a cylinder (along z); radius of a sphere. Scale of a
  /// mesh.
  Vector3<double> size{1, 1, 1};
  /// File of a mesh, as the URDF names it; of an unknown geometry its tag, empty without one.
  std::string mesh = {};
  std::optional<std::array<double, 4>> color = {};  ///< red, green, blue, alpha in [0, 1]
};

/// What a file says of how a link looks.
struct LinkVisuals {
  std::string link;  ///< as the file names it
  std::vector<VisualShape> visual, collision;
  /// About the link's origin; none without a mass or with numbers that cannot be read.
  std::optional<Inertia<double>> inertia = {};
};

/// All links of a URDF that parse_urdf accepts. Never an error: a shape that cannot be read is
/// unknown, of a document that is none there are no links.
std::vector<LinkVisuals> urdf_visuals(std::string_view xml);

}  // namespace conddp
