#include "robot/urdf/urdf_meshes.hpp"

#include <cctype>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <sstream>

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

/// Vertices of a binary STL. A head of 84 bytes ends with the number of facets. Each facet has 50
/// bytes: the normal, three vertices of three floats, and two bytes.
std::vector<Vector3<double>> binary_stl(std::string_view bytes) {
  constexpr std::size_t kHead = 84, kFacet = 50, kNormal = 12;
  std::vector<Vector3<double>> points;
  std::uint32_t facets = 0;
  if (bytes.size() < kHead) return points;
  std::memcpy(&facets, bytes.data() + kHead - sizeof facets, sizeof facets);
  if (facets == 0 || (bytes.size() - kHead) / kFacet < facets) return points;
  for (std::uint32_t i = 0; i < facets; ++i) {
    float numbers[9];
    std::memcpy(numbers, bytes.data() + kHead + kFacet * i + kNormal, sizeof numbers);
    for (int k = 0; k < 9; k += 3) points.push_back({numbers[k], numbers[k + 1], numbers[k + 2]});
  }
  return points;
}

/// Lines that begin with a word and three numbers: `vertex` in STL, `v` in OBJ.
std::vector<Vector3<double>> lines_with(std::string_view word, std::string_view bytes) {
  std::vector<Vector3<double>> points;
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first;
    Vector3<double> point;
    if (words >> first && first == word && words >> point.x >> point.y >> point.z)
      points.push_back(point);
  }
  return points;
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
  return suffix == ".stl" || suffix == ".obj" ? suffix.substr(1) : "";
}

std::vector<Vector3<double>> mesh_points(std::string_view bytes, const std::string& kind) {
  std::vector<Vector3<double>> points;
  if (kind == "stl") points = binary_stl(bytes);
  if (points.empty()) points = lines_with(kind == "stl" ? "vertex" : "v", bytes);
  std::erase_if(points, [](const Vector3<double>& p) { return !std::isfinite(p.x + p.y + p.z); });
  return points;
}

}  // namespace conddp
