#include "problem_file/motion/swing_arc.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace conddp {
namespace {

/// Depth below the terrain that counts, m.
constexpr double kDepth = 0.01;
/// Samples of an arc: 1 cm apart in a step of 0.6 m.
constexpr int kSamples = 64;

double along(double s) { return s * s * (3 - 2 * s); }
double above(double height, double s) { return 16 * height * s * s * (1 - s) * (1 - s); }

/// Vertical distance of the frame from the ground below it in the initial state.
double initial_distance(const SwingArc& arc, const TerrainSpec& terrain) {
  const double ground = ground_height(terrain, arc.first.p);
  return std::isfinite(ground) ? arc.first.p.z - ground : 0;
}

/// Smallest height of the contact points above the terrain.
double clearance(const SwingArc& arc, double s, const std::vector<Vector3<double>>& points,
                 const TerrainSpec& terrain) {
  const Matrix3<double> R = rotation_matrix(arc.orientation(s));
  double least = std::numeric_limits<double>::infinity();
  for (const Vector3<double>& point : points) {
    const Vector3<double> p = arc.place(s) + R * point;
    least = std::min(least, p.z - ground_height(terrain, p));
  }
  return least - initial_distance(arc, terrain);
}

}  // namespace

Vector3<double> SwingArc::place(double s) const {
  const double share = along(s);
  return {from.p.x + share * (to.p.x - from.p.x), from.p.y + share * (to.p.y - from.p.y),
          from.p.z + share * (to.p.z - from.p.z) + above(height, s)};
}

Quaternion<double> SwingArc::orientation(double s) const {
  const double share = along(s);
  const Vector3<double> normal = from.normal + share * (to.normal - from.normal);
  return orientation_at({from.p, from.yaw + share * (to.yaw - from.yaw),
                         (1 / std::sqrt(squared_norm(normal))) * normal},
                        first, stance);
}

double clearing_height(const SwingArc& arc, const std::vector<Vector3<double>>& points,
                       const TerrainSpec& terrain) {
  SwingArc line = arc;
  line.height = 0;
  double raised = 0;
  for (int i = kSamples / 4; i <= 3 * kSamples / 4; ++i) {
    const double s = static_cast<double>(i) / kSamples;
    raised = std::max(raised, -clearance(line, s, points, terrain) / above(1, s));
  }
  return arc.height + raised;
}

void warn_of_terrain(const SwingArc& arc, const std::vector<Vector3<double>>& points,
                     const TerrainSpec& terrain, const NamedStep& step, Diagnostics& out) {
  const Vector3<double>& p = arc.to.p;
  const std::string name = fmt::format("step {} of '{}' to [{:.3f}, {:.3f}, {:.3f}]", step.number,
                                       step.foot, p.x, p.y, p.z);
  if (is_on_edge(arc.to, arc.first, arc.stance, points, terrain))
    out.warning(
        step.place,
        fmt::format("{} lands {} of the terrain", name,
                    points.size() > 1 ? "where a corner of the sole is over an edge"
                                      : fmt::format("less than {:g} m from an edge", kNearEdge)),
        "change the length of the steps, or where the robot begins");
  double depth = 0;
  for (int i = 1; i < kSamples; ++i)
    depth = std::max(depth, -clearance(arc, static_cast<double>(i) / kSamples, points, terrain));
  if (depth > kDepth)
    out.warning(step.place,
                fmt::format("{} passes through the terrain, up to {:.3f} m deep", name, depth),
                "raise the height of the swings, or change the length of the steps");
}

}  // namespace conddp
