#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "spatial/vector3.hpp"

namespace conddp {

/// The path of a URDF mesh: relative to the URDF, or for package://name/path in a folder `name` of
/// one of its ancestors. Empty if there is no such file.
std::filesystem::path find_mesh(const std::string& name, const std::filesystem::path& urdf);

/// "stl" or "obj", from the suffix of the name; empty for others.
std::string mesh_kind(const std::string& name);

/// The vertices of a mesh in its own unit, several times where facets share them. Empty for bytes
/// that hold another kind (mesh_kind()). Numbers that are not finite are left out.
std::vector<Vector3<double>> mesh_points(std::string_view bytes, const std::string& kind);

}  // namespace conddp
