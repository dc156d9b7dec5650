#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "robot/urdf/mesh_parts.hpp"

namespace conddp {

/// A mesh, or the reason why there is none.
struct MeshFile {
  std::vector<MeshPart> parts;
  std::string defect;  ///< a clause or sentence; empty on success
  /// The files that were read with their bytes: the mesh itself, and those that it names.
  std::vector<std::pair<std::filesystem::path, std::string>> sources;
};

/// Formats that read_mesh_file() reads, for messages.
inline constexpr const char* kMeshFormats = "STL, OBJ, Collada and glTF";

/// Reads a file of a kind that mesh_kind() knows.
MeshFile read_mesh_file(const std::filesystem::path& file);

}  // namespace conddp
