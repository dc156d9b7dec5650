#pragma once

#include <filesystem>
#include <string>

namespace conddp {

/// The path of a URDF mesh: relative to the URDF, or for package://name/path in a folder `name` of
/// one of its ancestors. Empty if there is no such file.
std::filesystem::path find_mesh(const std::string& name, const std::filesystem::path& urdf);

/// "stl", "obj", "dae" (Collada), "gltf" or "glb", from the suffix of the name; empty for others.
std::string mesh_kind(const std::string& name);

}  // namespace conddp
