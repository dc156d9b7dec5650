#include "robot/urdf/mesh_file.hpp"

#include <fmt/format.h>

#include "base/files/text_file.hpp"
#include "robot/urdf/urdf_meshes.hpp"

namespace conddp {

MeshFile read_mesh_file(const std::filesystem::path& file) {
  TextFile main = read_text_file(file, kMaxDataBytes);
  if (!main.defect.empty()) return {.defect = std::move(main.defect)};
  MeshFile mesh;
  const ReadSideFile read = [&](const std::string& name) {
    const std::filesystem::path source = file.parent_path() / name;
    TextFile side = read_text_file(source, kMaxDataBytes);
    if (!side.defect.empty()) throw MeshDefect(side.defect);
    mesh.sources.emplace_back(source, side.text);
    return std::move(side.text);
  };
  try {
    mesh.parts = mesh_parts(main.text, mesh_kind(file.string()), read);
  } catch (const MeshDefect& defect) {
    mesh.defect = fmt::format("'{}': {}", file.filename().string(), defect.what());
  }
  mesh.sources.emplace_back(file, std::move(main.text));
  return mesh;
}

}  // namespace conddp
