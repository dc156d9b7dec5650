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
  /// Edges of a box, radius and length of a cylinder (along z), radius of a sphere, all in m; or
  /// the scale of a mesh.
  Vector3<double> size{1, 1, 1};
  /// File of a mesh, as named in the URDF; for an unknown geometry its tag, or empty without one.
  std::string mesh = {};
  std::optional<std::array<double, 4>> color = {};  ///< red, green, blue, alpha in [0, 1]
};

/// Shapes and inertia of a link.
struct LinkVisuals {
  std::string link;  ///< as the file names it
  std::vector<VisualShape> visual, collision;
  /// About the link's origin; absent without a positive mass or an <inertia> element.
  std::optional<Inertia<double>> inertia = {};
};

/// All links of a URDF that parse_urdf accepts. Never fails: an unreadable shape is `unknown`, and
/// a document that is not well-formed XML yields an empty list.
std::vector<LinkVisuals> urdf_visuals(std::string_view xml);

}  // namespace conddp
