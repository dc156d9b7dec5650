#include "problem_file/motion/footholds.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "problem_file/model/named_phases.hpp"
#include "problem_file/motion/planar_motion.hpp"

namespace conddp {
namespace {

/// The cosine of about 84 degrees.
constexpr double kSteepest = 0.1;

bool is_swing_of(const CostSpec& cost, const std::string& frame) {
  const Name* name = cost.keys.find(key::frame);
  return cost.keys.find(key::swing) != nullptr && name != nullptr && name->value == frame;
}

/// The normal of the ground under a frame, in the world.
Vector3<double> ground_normal(const std::string& frame, const ProblemSpec& spec) {
  for (const ContactSpec& contact : spec.contacts)
    if (contact.frame.value == frame && contact.axes == FrameAxes::world_aligned)
      return contact.normal;
  return {0, 0, 1};
}

/// The ground under a point, if a foot can stand on it.
std::optional<Ground> firm_ground(const TerrainSpec& terrain, const Vector3<double>& p) {
  const auto ground = ground_at(terrain, p.x, p.y);
  return ground && ground->normal.z >= kSteepest ? ground : std::nullopt;
}

/// The first foothold of a foot.
Foothold first_foothold(const Foot& foot, const TerrainSpec& terrain) {
  return {foot.start, 0, firm_ground(terrain, foot.start).value_or(Ground()).normal};
}

/// The place of a foot that moves with the base from the initial state, without regard to ground.
std::optional<Vector3<double>> displaced_place(const Foot& foot, const PlanarMotion& motion,
                                               const Plant& plant,
                                               const std::vector<double>& initial) {
  const int joint = plant.robot().frames[foot.frame].joint;
  if (joint < 0) return std::nullopt;
  return displaced_point(plant, part_of(plant, joint), motion, initial, foot.start);
}

/// The foothold at a place, as far above the terrain along its normal as the foot is at first.
std::optional<Foothold> on_terrain(const Foot& foot, Vector3<double> p, const PlanarMotion& motion,
                                   const TerrainSpec& terrain) {
  const auto before = firm_ground(terrain, foot.start), ground = firm_ground(terrain, p);
  if (!before || !ground) return std::nullopt;
  const double above = (foot.start.z - before->height) * before->normal.z;
  p.z = ground->height + above / ground->normal.z + motion.rise;
  return Foothold{p, motion.yaw, ground->normal};
}

/// True if the ground at a point is missing or off the plane of a foothold.
bool is_off(const Vector3<double>& p, const Foothold& foothold, const TerrainSpec& terrain) {
  constexpr double kEdge = 0.01;  // least height of an edge, m
  const Vector3<double> from = p - foothold.p, &n = foothold.normal;
  const double plane = ground_height(terrain, foothold.p) - (n.x * from.x + n.y * from.y) / n.z;
  return !(std::abs(ground_height(terrain, p) - plane) <= kEdge);
}

/// Points of a circle in the horizontal plane, from the x axis on.
std::vector<Vector3<double>> circle(double radius) {
  constexpr int kDirections = 16;
  std::vector<Vector3<double>> points;
  for (int i = 0; i < kDirections; ++i) {
    const double angle = 2 * std::numbers::pi * i / kDirections;
    points.push_back({radius * std::cos(angle), radius * std::sin(angle), 0});
  }
  return points;
}

/// The largest distance of a foot's border from its frame's origin, m.
double radius_of(const std::vector<Vector3<double>>& points) {
  double radius = kNearEdge;
  for (const Vector3<double>& point : points)
    radius = std::max(radius, std::sqrt(squared_norm(point)));
  return radius;
}

/// The shortest rotation from the vertical to a unit vector.
Quaternion<double> tilt_to(const Vector3<double>& normal) {
  const double half = std::sqrt((1 + normal.z) / 2);
  return {-normal.y / (2 * half), normal.x / (2 * half), 0, half};
}

/// A swing and its runs, in the order of time.
struct Swing {
  const SwingSpec* spec;
  std::vector<SwingRun> runs;
};

}  // namespace

Quaternion<double> orientation_at(const Foothold& foothold, const Foothold& first,
                                  const Quaternion<double>& initial) {
  const double half = foothold.yaw / 2;
  const Quaternion<double> turn{0, 0, std::sin(half), std::cos(half)};
  const Quaternion<double> back = tilt_to({-first.normal.x, -first.normal.y, first.normal.z});
  return tilt_to(foothold.normal) * (turn * (back * initial));
}

std::vector<Vector3<double>> contact_points(const ContactSpec& contact) {
  if (contact.kind != ContactKind::surface || !contact.half_size) return {Vector3<double>::zero()};
  const auto [x, y] = *contact.half_size;
  return {{x, y, 0}, {x, -y, 0}, {-x, y, 0}, {-x, -y, 0}};
}

std::vector<Vector3<double>> contact_points(const std::string& frame, const ProblemSpec& spec) {
  const auto contact =
      std::ranges::find(spec.contacts, frame, [](const ContactSpec& c) { return c.frame.value; });
  return contact == spec.contacts.end() ? std::vector{Vector3<double>::zero()}
                                        : contact_points(*contact);
}

bool is_on_edge(const Foothold& foothold, const Foothold& first, const Quaternion<double>& initial,
                const std::vector<Vector3<double>>& points, const TerrainSpec& terrain) {
  const Matrix3<double> R = rotation_matrix(orientation_at(foothold, first, initial));
  const auto is_off_at = [&](const Vector3<double>& from) {
    return is_off(foothold.p + from, foothold, terrain);
  };
  if (points.size() == 1) return std::ranges::any_of(circle(kNearEdge), is_off_at);
  return std::ranges::any_of(points, [&](const auto& point) { return is_off_at(R * point); });
}

namespace {

/// The foothold nearest to a place that is not on an edge. The clear side of a single edge is no
/// farther than the foot reaches; where there is none, the place itself.
std::optional<Foothold> beside_edges(const Foot& foot, const Vector3<double>& place,
                                     const PlanarMotion& motion, const ProblemSpec& spec,
                                     const Plant& plant, const std::vector<double>& initial) {
  const std::vector<Vector3<double>> points = contact_points(foot.name, spec);
  const Foothold first = first_foothold(foot, spec.terrain);
  const Quaternion<double> stance =
      quaternion(placement_in_state(*plant.multibody(), initial, foot.frame).R);
  const auto at = [&](const Vector3<double>& shift) {
    return on_terrain(foot, place + shift, motion, spec.terrain);
  };
  const auto is_clear = [&](const std::optional<Foothold>& foothold) {
    return foothold && !is_on_edge(*foothold, first, stance, points, spec.terrain);
  };
  const auto own = at({});
  if (is_clear(own)) return own;
  constexpr int kRings = 10;
  const double radius = radius_of(points);
  for (int ring = 1; ring <= kRings; ++ring)
    for (const Vector3<double>& shift : circle(ring * radius / kRings))
      if (const auto foothold = at(shift); is_clear(foothold)) return foothold;
  return own;
}

}  // namespace

std::optional<Foothold> displaced_foothold(const Foot& foot, const PlanarMotion& motion,
                                           const ProblemSpec& spec, const Plant& plant,
                                           const std::vector<double>& initial) {
  auto p = displaced_place(foot, motion, plant, initial);
  if (p && !spec.terrain.empty()) return beside_edges(foot, *p, motion, spec, plant, initial);
  const Vector3<double> normal = ground_normal(foot.name, spec);
  if (!p || normal.z < kSteepest) return std::nullopt;
  p->z -= (normal.x * (p->x - foot.start.x) + normal.y * (p->y - foot.start.y)) / normal.z;
  return Foothold{*p, motion.yaw};
}

std::vector<SwingRun> swing_runs(const std::vector<bool>& chosen, const ProblemSpec& spec) {
  std::vector<SwingRun> runs;
  int knot = 0;
  for (std::size_t p = 0; p < chosen.size(); ++p) {
    const int end = knot + spec.phases[p].knots.value;
    if (chosen[p] && (p == 0 || !chosen[p - 1])) runs.push_back({p, p + 1, knot, end});
    if (chosen[p]) {
      runs.back().end_phase = p + 1;
      runs.back().last = end;
    }
    knot = end;
  }
  return runs;
}

bool swings(const std::string& frame, const ProblemSpec& spec) {
  return std::any_of(spec.costs.begin(), spec.costs.end(),
                     [&](const CostSpec& cost) { return is_swing_of(cost, frame); });
}

namespace {

/// The swings of a foot.
std::vector<Swing> swings_of(const Foot& foot, const ProblemSpec& spec) {
  std::vector<Swing> all;
  for (const CostSpec& cost : spec.costs)
    if (is_swing_of(cost, foot.name))
      all.push_back(
          {cost.keys.find(key::swing), swing_runs(phases_named(cost.phases, spec), spec)});
  return all;
}

/// Landing of a swing from `from` in a run; empty if the swing does not define it.
std::optional<Foothold> landing_of(const SwingSpec& swing, std::size_t run, const Foothold& from,
                                   const Foot& foot, const ProblemSpec& spec, const Plant& plant,
                                   const std::vector<double>& initial) {
  if (!swing.displaced.empty())
    return run < swing.displaced.size()
               ? displaced_foothold(foot, swing.displaced[run], spec, plant, initial)
               : std::nullopt;
  const Vector3<double> p =
      swing.landing.value_or(from.p + swing.step.value_or(Vector3<double>::zero()));
  return Foothold{p, from.yaw, firm_ground(spec.terrain, p).value_or(Ground()).normal};
}

}  // namespace

std::vector<Foothold> footholds(const Foot& foot, const ProblemSpec& spec, const Plant& plant,
                                const std::vector<double>& initial) {
  const std::vector<Swing> all = swings_of(foot, spec);
  const std::size_t n = spec.phases.size();
  std::vector<Foothold> places(n + 1, first_foothold(foot, spec.terrain));
  for (std::size_t p = 1; p <= n; ++p) {
    places[p] = places[p - 1];
    for (const auto& [swing, runs] : all)
      for (std::size_t i = 0; i < runs.size(); ++i) {
        if (runs[i].end_phase != p) continue;
        const Foothold& from = places[runs[i].first_phase];
        places[p] = landing_of(*swing, i, from, foot, spec, plant, initial).value_or(places[p]);
      }
  }
  return places;
}

namespace {

/// Reports the first step of a foot, or its start, without ground on which it can stand.
bool check_ground(const SwingSpec& swing, const Foot& foot, const ProblemSpec& spec,
                  const Plant& plant, const std::vector<double>& initial, Diagnostics& out) {
  const auto fail = [&](const Vector3<double>& p, const std::string& when) {
    const auto steep = ground_at(spec.terrain, p.x, p.y);
    out.error(swing.place,
              fmt::format("the terrain {} for '{}' at [{:.3g}, {:.3g}], where it {}",
                          steep ? fmt::format("is too steep ({:.1f}°, {:.4g} m high)",
                                              std::acos(steep->normal.z) * 180 / std::numbers::pi,
                                              steep->height)
                                : "has no ground",
                          foot.name, p.x, p.y, when),
              steep
                  ? "change the terrain ('scale' of a height map, whose numbers are m by default), "
                    "or the steps"
                  : "add 'ground: {half_space: {}}' to 'terrain', or change the steps");
    return false;
  };
  if (!firm_ground(spec.terrain, foot.start)) return fail(foot.start, "begins");
  for (std::size_t i = 0; i < swing.displaced.size(); ++i)
    if (!displaced_foothold(foot, swing.displaced[i], spec, plant, initial))
      return fail(*displaced_place(foot, swing.displaced[i], plant, initial),
                  fmt::format("lands after its step {}", i + 1));
  return true;
}

}  // namespace

bool check_landings(const CostSpec& cost, const Foot& foot, std::size_t runs,
                    const ProblemSpec& spec, const Plant& plant, const std::vector<double>& initial,
                    Diagnostics& out) {
  const SwingSpec& swing = *cost.keys.find(key::swing);
  if (swing.displaced.empty()) return true;
  if (swing.displaced.size() != runs) {
    out.error(swing.place,
              fmt::format("'{}' swings {} {}, and 'displaced' has {} {}", foot.name, runs,
                          runs == 1 ? "time" : "times", swing.displaced.size(),
                          swing.displaced.size() == 1 ? "landing" : "landings"),
              "give one '[x, y, yaw]' for every run of consecutive phases of the cost");
    return false;
  }
  if (!displaced_place(foot, swing.displaced.front(), plant, initial)) {
    out.error(swing.place, "the robot's base is fixed: a landing cannot be displaced with it",
              "write 'base: floating' under 'robot', or give the swing a 'landing' or 'step'");
    return false;
  }
  if (!spec.terrain.empty()) return check_ground(swing, foot, spec, plant, initial, out);
  if (ground_normal(foot.name, spec).z < kSteepest) {
    out.error(swing.place,
              fmt::format("the ground under '{}' is too steep for a landing that is displaced in "
                          "the horizontal plane",
                          foot.name),
              "give 'landing' or 'step'");
    return false;
  }
  return true;
}

}  // namespace conddp
