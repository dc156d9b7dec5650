#include "robot/urdf/urdf_meshes.hpp"

#include <cctype>

namespace conddp {
namespace {

bool is_file(const std::filesystem::path& file) {
  std::error_code error;
  return std::filesystem::is_regular_file(file, error);
}

/// Finds a file `package/path` in a folder or its ancestors; one of these may be the package
/// itself.
std::filesystem::path find_in_package(const std::filesystem::path& inside,
                                      std::filesystem::path base) {
  const std::filesystem::path rest = inside.lexically_relative(*inside.begin());
  for (int up = 0; up < 6; ++up, base = base.parent_path()) {
    if (is_file(base / inside)) return base / inside;
    if (base.filename() == *inside.begin() && is_file(base / rest)) return base / rest;
  }
  return {};
}

}  // namespace

std::filesystem::path find_mesh(const std::string& name, const std::filesystem::path& urdf) {
  const std::filesystem::path folder = urdf.parent_path();
  constexpr std::string_view kFile = "file://", kPackage = "package://";
  if (name.starts_with(kFile))
    return is_file(name.substr(kFile.size())) ? name.substr(kFile.size()) : "";
  if (!name.starts_with(kPackage)) return is_file(folder / name) ? folder / name : "";
  const std::filesystem::path inside = name.substr(kPackage.size());
  if (inside.empty()) return {};
  // Absolute, because the parent of a file in the current folder is empty.
  return find_in_package(inside, std::filesystem::absolute(urdf).parent_path());
}

std::string mesh_kind(const std::string& name) {
  std::string suffix = std::filesystem::path(name).extension().string();
  for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  for (const char* known : {".stl", ".obj", ".dae", ".gltf", ".glb"})
    if (suffix == known) return suffix.substr(1);
  return {};
}

}  // namespace conddp
