#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "spatial/se3.hpp"

namespace conddp {

enum class ShapeKind { box, cylinder, sphere, mesh };

/// What a link looks like.
struct VisualShape {
  std::string link;  ///< as the file names it
  ShapeKind kind = ShapeKind::box;
  SE3<double> placement = SE3<double>::identity();  ///< in the link's frame
  /// m: edges of a box; radius and length of a cylinder (along z); radius of a sphere. Scale of a
  /// mesh.
  Vector3<double> size{1, 1, 1};
  std::string mesh = {};                            ///< file, as the URDF names it
  std::optional<std::array<double, 4>> color = {};  ///< red, green, blue, alpha in [0, 1]
};

/// The shapes of a URDF that parse_urdf accepts: visual ones, for links without any those of
/// collisions. Never an error: what cannot be read is left out.
std::vector<VisualShape> urdf_visuals(std::string_view xml);

}  // namespace conddp
