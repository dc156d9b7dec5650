#include "problem_file/motion/terrain.hpp"

#include <cmath>
#include <limits>

#include "problem_file/data/height_map.hpp"

namespace conddp {
namespace {

constexpr double kUpright = 1e-9;  ///< sine of angles that count as zero

/// Where the vertical leaves the box at its upper end.
std::optional<Ground> ground_of(const BoxSpec& box, double x, double y) {
  const SE3<double> placement = box.placement.placement();
  const Vector3<double> from = transpose_times(placement.R, Vector3<double>{x, y, 0} - placement.p);
  const Vector3<double> up = transpose_times(placement.R, Vector3<double>{0, 0, 1});
  double low = -std::numeric_limits<double>::infinity(), high = -low;
  Vector3<double> normal{0, 0, 1};
  for (int axis = 0; axis < 3; ++axis) {
    const double half = box.size[axis] / 2;
    if (std::abs(up[axis]) < kUpright) {
      if (std::abs(from[axis]) > half) return std::nullopt;
      continue;
    }
    const double side = up[axis] > 0 ? 1 : -1;
    const double exit = (side * half - from[axis]) / up[axis];
    low = std::max(low, (-side * half - from[axis]) / up[axis]);
    if (exit >= high) continue;
    high = exit;
    normal = side * placement.R.column(axis);
  }
  if (low > high) return std::nullopt;
  return Ground{high, normal};
}

std::optional<Ground> ground_of(const HalfSpaceSpec& half_space, double x, double y) {
  const auto& [n, p] = half_space;
  if (n.z < kUpright) return std::nullopt;
  return Ground{p.z - (n.x * (x - p.x) + n.y * (y - p.y)) / n.z, n};
}

std::optional<Ground> ground_of(const HeightMapSpec& map, double x, double y) {
  const auto on = height_on(map, x, y);
  if (!on) return std::nullopt;
  const auto [height, along_x, along_y] = *on;
  const Vector3<double> normal{-along_x, -along_y, 1};
  return Ground{height, (1 / std::sqrt(squared_norm(normal))) * normal};
}

}  // namespace

std::optional<Ground> ground_at(const TerrainSpec& terrain, double x, double y) {
  std::optional<Ground> highest;
  for (const TerrainPieceSpec& piece : terrain) {
    const auto ground =
        std::visit([&](const auto& form) { return ground_of(form, x, y); }, piece.form);
    if (ground && (!highest || ground->height > highest->height)) highest = ground;
  }
  return highest;
}

double ground_height(const TerrainSpec& terrain, const Vector3<double>& p) {
  const auto ground = ground_at(terrain, p.x, p.y);
  return ground ? ground->height : -std::numeric_limits<double>::infinity();
}

}  // namespace conddp
