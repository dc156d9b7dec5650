#include "output/scene/scene_meshes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/text/base64.hpp"
#include "robot/urdf/mesh_file.hpp"

namespace conddp {
namespace {

template <class Integer>
void append(std::string& bytes, std::uint64_t value) {
  for (std::size_t i = 0; i < sizeof(Integer); ++i)
    bytes += static_cast<char>(value >> (8 * i) & 0xff);
}

OrderedJson part_json(const MeshPart& part) {
  constexpr double kCells = std::numeric_limits<std::uint16_t>::max();
  const Bounds box(part.vertices);
  const Vector3<double>& low = box.low;
  const double step = box.longest() > 0 ? box.longest() / kCells : 1;
  std::string positions, triangles;
  for (const Vector3<double>& p : part.vertices)
    for (int axis = 0; axis < 3; ++axis)
      append<std::uint16_t>(positions, std::lround((p[axis] - low[axis]) / step));
  const bool few = part.vertices.size() <= 1u << 16;
  for (const auto& triangle : part.triangles)
    for (const std::uint32_t i : triangle)
      few ? append<std::uint16_t>(triangles, i) : append<std::uint32_t>(triangles, i);
  OrderedJson json = {{"low", {low.x, low.y, low.z}},
                      {"step", step},
                      {"positions", base64(positions)},
                      {"triangles", base64(triangles)}};
  if (part.color) json["color"] = *part.color;
  return json;
}

}  // namespace

std::optional<std::size_t> SceneMeshes::add(const std::filesystem::path& file, std::string& why) {
  why = "mesh not found";
  if (file.empty()) return std::nullopt;
  if (const auto found = known_.find(file); found != known_.end()) return found->second;
  auto [parts, defect, sources] = read_mesh_file(file);
  why = "mesh not readable: " + defect;
  if (!defect.empty()) return std::nullopt;
  std::erase_if(parts, [](const MeshPart& part) { return part.triangles.empty(); });
  why = "no surface inside";
  if (parts.empty()) return std::nullopt;
  for (const MeshPart& part : parts) triangles_ += part.triangles.size();
  known_.emplace(file, meshes_.size());
  meshes_.push_back(std::move(parts));
  return meshes_.size() - 1;
}

OrderedJson SceneMeshes::json() const {
  const double share =
      std::min(1.0, static_cast<double>(kMostTriangles) / static_cast<double>(triangles_));
  OrderedJson list = OrderedJson::array();
  for (const std::vector<MeshPart>& parts : meshes_) {
    OrderedJson mesh = OrderedJson::array();
    for (const MeshPart& part : parts) {
      const double most = share * static_cast<double>(part.triangles.size());
      mesh.push_back(
          part_json(simplified(part, std::max(kFewestTriangles, static_cast<std::size_t>(most)))));
    }
    list.push_back(std::move(mesh));
  }
  return list;
}

}  // namespace conddp
