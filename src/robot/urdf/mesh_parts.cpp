#include "robot/urdf/mesh_parts.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>
#include <set>
#include <sstream>

namespace conddp {
namespace {

bool is_finite(const Vector3<double>& p) { return std::isfinite(p.x + p.y + p.z); }

/// Appends a facet with vertices of its own.
void add_facet(const std::array<Vector3<double>, 3>& corners, MeshPart& part) {
  if (!std::ranges::all_of(corners, is_finite)) return;
  const auto first = static_cast<std::uint32_t>(part.vertices.size());
  part.vertices.insert(part.vertices.end(), corners.begin(), corners.end());
  part.triangles.push_back({first, first + 1, first + 2});
}

/// A binary STL. A head of 84 bytes ends with the number of facets. Each facet has 50 bytes: the
/// normal, three vertices of three floats, and two bytes.
MeshPart binary_stl(std::string_view bytes) {
  constexpr std::size_t kHead = 84, kFacet = 50, kNormal = 12;
  MeshPart part;
  std::uint32_t facets = 0;
  if (bytes.size() < kHead) return part;
  std::memcpy(&facets, bytes.data() + kHead - sizeof facets, sizeof facets);
  if (facets == 0 || (bytes.size() - kHead) / kFacet < facets) return part;
  for (std::uint32_t i = 0; i < facets; ++i) {
    float n[9];
    std::memcpy(n, bytes.data() + kHead + kFacet * i + kNormal, sizeof n);
    add_facet({{{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, {n[6], n[7], n[8]}}}, part);
  }
  return part;
}

/// Three numbers, or NaN.
Vector3<double> point_of(std::istringstream& words) {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  Vector3<double> point{kNone, kNone, kNone};
  words >> point.x >> point.y >> point.z;
  return words ? point : Vector3<double>{kNone, kNone, kNone};
}

/// Every three lines `vertex x y z` are a facet.
MeshPart ascii_stl(std::string_view bytes) {
  MeshPart part;
  std::vector<Vector3<double>> corners;
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string first;
    if (!(words >> first) || first != "vertex") continue;
    corners.push_back(point_of(words));
    if (corners.size() < 3) continue;
    add_facet({corners[0], corners[1], corners[2]}, part);
    corners.clear();
  }
  return part;
}

/// Index of a vertex in a corner such as `7/3/2`, or `-1` for the last one; −1 for a missing one.
long corner_of(const std::string& word, std::size_t count) {
  long number = 0;
  if (std::from_chars(word.data(), word.data() + word.size(), number).ec != std::errc()) return -1;
  const long index = number < 0 ? static_cast<long>(count) + number : number - 1;
  return index >= 0 && index < static_cast<long>(count) ? index : -1;
}

/// Lines `v x y z` and `f corner corner corner ...` of an OBJ file; polygons become fans.
MeshPart obj(std::string_view bytes) {
  MeshPart part;
  std::istringstream lines{std::string(bytes)};
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string word;
    if (!(words >> word)) continue;
    if (word == "v") part.vertices.push_back(point_of(words));
    if (word != "f") continue;
    std::vector<long> corners;
    while (words >> word) corners.push_back(corner_of(word, part.vertices.size()));
    if (std::ranges::find(corners, -1) != corners.end()) continue;
    for (std::size_t i = 2; i < corners.size(); ++i)
      part.triangles.push_back({static_cast<std::uint32_t>(corners[0]),
                                static_cast<std::uint32_t>(corners[i - 1]),
                                static_cast<std::uint32_t>(corners[i])});
  }
  return part;
}

/// Leaves out vertices that are not finite, and their triangles.
void keep_finite(MeshPart& part) {
  static constexpr std::uint32_t kGone = 0xffffffff;
  std::vector<std::uint32_t> place;
  std::vector<Vector3<double>> kept;
  for (const Vector3<double>& p : part.vertices) {
    place.push_back(is_finite(p) ? static_cast<std::uint32_t>(kept.size()) : kGone);
    if (is_finite(p)) kept.push_back(p);
  }
  part.vertices = std::move(kept);
  for (auto& triangle : part.triangles)
    for (std::uint32_t& i : triangle) i = place[i];
  std::erase_if(part.triangles, [](const auto& triangle) {
    return std::ranges::find(triangle, kGone) != triangle.end();
  });
}

using Cell = std::array<std::uint32_t, 3>;

/// The part with one vertex for each cell of an edge length, and without triangles that collapse.
MeshPart clustered(const MeshPart& part, const Vector3<double>& low, double edge) {
  MeshPart out;
  out.color = part.color;
  std::map<Cell, std::uint32_t> cells;
  std::vector<std::uint32_t> place, members;
  for (const Vector3<double>& p : part.vertices) {
    Cell cell{};
    for (int axis = 0; axis < 3 && edge > 0; ++axis)
      cell[axis] = static_cast<std::uint32_t>((p[axis] - low[axis]) / edge);
    const auto [at, is_new] = cells.try_emplace(cell, static_cast<std::uint32_t>(members.size()));
    if (is_new) out.vertices.push_back(Vector3<double>::zero()), members.push_back(0);
    const std::uint32_t index = at->second;
    out.vertices[index] = out.vertices[index] + p;
    ++members[index];
    place.push_back(index);
  }
  for (std::size_t i = 0; i < members.size(); ++i)
    out.vertices[i] = (1.0 / members[i]) * out.vertices[i];
  std::set<std::array<std::uint32_t, 3>> known;
  for (const auto& [a, b, c] : part.triangles) {
    const std::array<std::uint32_t, 3> triangle{place[a], place[b], place[c]};
    if (triangle[0] == triangle[1] || triangle[1] == triangle[2] || triangle[2] == triangle[0])
      continue;
    auto sorted = triangle;
    std::ranges::sort(sorted);
    if (known.insert(sorted).second) out.triangles.push_back(triangle);
  }
  return out;
}

}  // namespace

Bounds::Bounds(const std::vector<Vector3<double>>& points) {
  constexpr double kMost = std::numeric_limits<double>::infinity();
  low = {kMost, kMost, kMost}, high = -low;
  for (const Vector3<double>& p : points)
    for (int axis = 0; axis < 3; ++axis) {
      low[axis] = std::min(low[axis], p[axis]);
      high[axis] = std::max(high[axis], p[axis]);
    }
}

double Bounds::longest() const {
  return std::max({high.x - low.x, high.y - low.y, high.z - low.z, 0.0});
}

std::vector<MeshPart> mesh_parts(std::string_view bytes, const std::string& kind,
                                 const ReadSideFile& read) {
  if (kind == "dae") return collada_parts(bytes);
  std::vector<MeshPart> parts;
  if (kind == "gltf" || kind == "glb")
    parts = gltf_parts(bytes, read);
  else
    parts.push_back(kind == "obj" ? obj(bytes) : binary_stl(bytes));
  if (kind == "stl" && parts[0].vertices.empty()) parts[0] = ascii_stl(bytes);
  std::ranges::for_each(parts, keep_finite);
  std::erase_if(parts, [](const MeshPart& part) { return part.vertices.empty(); });
  return parts;
}

MeshPart simplified(const MeshPart& part, std::size_t most) {
  constexpr double kMostCells = 65535, kCoarser = 1.15;
  const Bounds box(part.vertices);
  MeshPart simple = clustered(part, box.low, box.longest() / kMostCells);
  // A surface as large as a face of the box has about two triangles for each cell of that face.
  double edge = box.longest() / std::sqrt(2.0 * static_cast<double>(most));
  for (; simple.triangles.size() > most; edge *= kCoarser)
    simple = clustered(simple, box.low, edge);
  return simple;
}

}  // namespace conddp
