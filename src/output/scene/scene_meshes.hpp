#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <vector>

#include "base/json/ordered_json.hpp"
#include "robot/urdf/mesh_parts.hpp"

namespace conddp {

/// The mesh files of a page, each once. Larger pages open slowly: meshes that have more triangles
/// together than kMostTriangles, which take two megabytes or less, are simplified to that number.
/// No part loses triangles below kFewestTriangles, because long thin ones would lose their shape.
class SceneMeshes {
 public:
  static constexpr std::size_t kMostTriangles = 100'000, kFewestTriangles = 500;

  /// Index of a file's mesh. Without a surface empty, and `why` is the reason.
  std::optional<std::size_t> add(const std::filesystem::path& file, std::string& why);

  /// For each mesh its parts: `low` and `step` (in the file's unit), `positions` and `triangles` as
  /// base64, and `color`, if the file has it. Vertices are low + step · positions, with three
  /// unsigned 16-bit numbers each. Triangles have three indices, of 16 bits if they suffice, else
  /// of
  /// 32. All are little-endian.
  OrderedJson json() const;

 private:
  std::map<std::filesystem::path, std::size_t> known_;
  std::vector<std::vector<MeshPart>> meshes_;
  std::size_t triangles_ = 0;
};

}  // namespace conddp
