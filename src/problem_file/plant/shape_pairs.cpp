#include "problem_file/plant/shape_pairs.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "problem_file/model/components.hpp"

namespace conddp {
namespace {

using Form = std::variant<Capsule, Polytope, HalfSpace>;

Form form_of(const SphereSpec& sphere, int frame) {
  return Capsule{frame, sphere.center, sphere.center, sphere.radius};
}
Form form_of(const CapsuleSpec& capsule, int frame) {
  return Capsule{frame, capsule.from, capsule.to, capsule.radius};
}
template <class Spec>
Form form_of(const Spec& spec, int frame) {
  return polytope_of(spec, frame);
}
Form form_of(const HalfSpaceSpec& half_space, int) {
  return HalfSpace{half_space.normal, dot(half_space.normal, half_space.point)};
}

enum class ItemKind {
  kShape,
  kObstacle,
  kTerrain,  ///< feet touch it, so pairs must name it
};

/// A shape, an obstacle or a piece of the terrain, and the joint of the body that carries it.
struct Item {
  std::string name;
  std::string frame;  ///< that carries it; empty in the world
  ItemKind kind;
  int joint;
  Form form;
};

std::vector<Item> items_of(const ProblemSpec& spec, const RobotModel& robot) {
  std::vector<Item> items;
  for (const ShapeSpec& shape : spec.collision.shapes) {
    const int frame = *robot.find_frame(shape.frame.value);
    items.push_back(
        {shape.name.value, shape.frame.value, ItemKind::kShape, robot.frames[frame].joint,
         std::visit([&](const auto& form) { return form_of(form, frame); }, shape.form)});
  }
  for (const ObstacleSpec& obstacle : spec.collision.obstacles)
    items.push_back(
        {obstacle.name.value, "", ItemKind::kObstacle, -1,
         std::visit([](const auto& form) { return form_of(form, -1); }, obstacle.form)});
  for (const TerrainPieceSpec& piece : spec.terrain) {
    const auto add = [&](const auto& form) {
      items.push_back({piece.name.value, "", ItemKind::kTerrain, -1, form_of(form, -1)});
    };
    if (const auto* box = std::get_if<BoxSpec>(&piece.form)) add(*box);
    if (const auto* plane = std::get_if<HalfSpaceSpec>(&piece.form)) add(*plane);
  }
  return items;
}

/// True if two bodies are identical or connected by a joint.
bool are_neighbours(const RobotModel& robot, int a, int b) {
  const auto parent = [&](int joint) { return joint < 0 ? -2 : robot.joints[joint].parent; };
  return a == b || parent(a) == b || parent(b) == a;
}

/// The items that fit a name or a pattern; a name that fits no item is reported.
std::vector<std::size_t> items_named(const Name& name, const std::vector<Item>& items,
                                     Diagnostics& out) {
  std::vector<std::size_t> found;
  std::vector<std::string> known;
  for (std::size_t i = 0; i < items.size(); ++i) {
    known.push_back(items[i].name);
    if (fits(name.value, items[i].name)) found.push_back(i);
  }
  if (found.empty())
    out.error(
        name.place, fmt::format("unknown shape '{}'", name.value),
        known.empty() ? "the file has no 'collision'" : name_hint(name.value, known, "shapes"));
  return found;
}

/// Links carry no half-space.
DistancePair pair_of(const Form& shape, const Form& other) {
  if (const auto* polytope = std::get_if<Polytope>(&shape)) return {*polytope, other};
  return {std::get<Capsule>(shape), other};
}

/// Pairs of items, each once.
class PairList {
 public:
  explicit PairList(const std::vector<Item>& items) : items_(items) {}

  /// Returns false for items without relative motion. Shapes precede obstacles, so the smaller
  /// index is a shape on a link.
  bool add(std::size_t a, std::size_t b) {
    const auto [first, second] = std::minmax(a, b);
    const Item &shape = items_[first], &other = items_[second];
    if (shape.joint == other.joint) return false;
    if (taken_.insert({first, second}).second)
      pairs_.push_back({shape.name, other.name, pair_of(shape.form, other.form)});
    return true;
  }
  const std::vector<ShapePair>& pairs() const { return pairs_; }

 private:
  const std::vector<Item>& items_;
  std::vector<ShapePair> pairs_;
  std::set<std::pair<std::size_t, std::size_t>> taken_;
};

bool is_disabled(const Item& a, const Item& b, const CollisionSpec& collision) {
  return std::ranges::any_of(collision.disabled, [&](const auto& pair) {
    return (pair.first == a.frame && pair.second == b.frame) ||
           (pair.first == b.frame && pair.second == a.frame);
  });
}

/// True if a choice of pairs includes a shape with another item.
bool has_pair(PairsSpec::Choice choice, const Item& shape, const Item& other,
              const CollisionSpec& collision, const RobotModel& robot) {
  if (other.kind == ItemKind::kTerrain) return false;
  if (other.kind == ItemKind::kObstacle) return choice != PairsSpec::Choice::kSelf;
  return choice != PairsSpec::Choice::kObstacles &&
         !are_neighbours(robot, shape.joint, other.joint) && !is_disabled(shape, other, collision);
}

void add_chosen(PairsSpec::Choice choice, const std::vector<Item>& items,
                const CollisionSpec& collision, const RobotModel& robot, PairList& pairs) {
  if (choice == PairsSpec::Choice::kNamed) return;
  for (std::size_t a = 0; a < items.size() && items[a].kind == ItemKind::kShape; ++a)
    for (std::size_t b = a + 1; b < items.size(); ++b)
      if (has_pair(choice, items[a], items[b], collision, robot)) pairs.add(a, b);
}

void add_named(const Name& first, const Name& second, const std::vector<Item>& items,
               PairList& pairs, Diagnostics& out) {
  const auto firsts = items_named(first, items, out), seconds = items_named(second, items, out);
  if (firsts.empty() || seconds.empty()) return;
  bool moves = false;
  for (const std::size_t a : firsts)
    for (const std::size_t b : seconds) moves |= pairs.add(a, b);
  if (!moves)
    out.error(first.place, fmt::format("'{}' and '{}' do not move relative to each other",
                                       first.value, second.value));
}

}  // namespace

Polytope polytope_of(const BoxSpec& box, int frame) {
  Polytope polytope{frame, {}, 0};
  const SE3<double> placement = box.placement.placement();
  for (const double x : {-0.5, 0.5})
    for (const double y : {-0.5, 0.5})
      for (const double z : {-0.5, 0.5}) {
        const Vector3<double> corner{x * box.size.x, y * box.size.y, z * box.size.z};
        polytope.vertices.push_back(placement.R * corner + placement.p);
      }
  return polytope;
}

Polytope polytope_of(const CylinderSpec& cylinder, int frame) {
  constexpr int kFaces = 32;
  Polytope polytope{frame, {}, 0};
  const Vector3<double> along = cylinder.to - cylinder.from;
  const Vector3<double> beside =
      std::abs(along.x) > std::abs(along.y) ? Vector3<double>{0, 1, 0} : Vector3<double>{1, 0, 0};
  const auto unit = [](const Vector3<double>& v) { return (1 / std::sqrt(squared_norm(v))) * v; };
  const Vector3<double> x = unit(cross(along, beside)), y = unit(cross(along, x));
  const double radius = cylinder.radius / std::cos(std::numbers::pi / kFaces);
  for (int i = 0; i < kFaces; ++i) {
    const double angle = 2 * std::numbers::pi * i / kFaces;
    const Vector3<double> out = (radius * std::cos(angle)) * x + (radius * std::sin(angle)) * y;
    polytope.vertices.push_back(cylinder.from + out);
    polytope.vertices.push_back(cylinder.to + out);
  }
  return polytope;
}

Polytope polytope_of(const HullSpec& hull, int frame) {
  Polytope polytope{frame, hull.points, hull.radius};
  const SE3<double> placement = hull.placement.placement();
  for (Vector3<double>& vertex : polytope.vertices) vertex = placement.R * vertex + placement.p;
  return polytope;
}

void check_shapes(const ProblemSpec& spec, const Plant& plant, Diagnostics& out) {
  for (const ShapeSpec& shape : spec.collision.shapes)
    find_frame(plant.robot(), shape.frame, "", out);
}

std::vector<ShapePair> shape_pairs(const CostSpec& cost, const ProblemSpec& spec,
                                   const Plant& plant, Diagnostics& out) {
  const RobotModel& robot = plant.robot();
  const std::vector<Item> items = items_of(spec, robot);
  const PairsSpec asked = cost.keys.value(key::pairs);
  PairList list(items);
  add_chosen(asked.choice, items, spec.collision, robot, list);
  const int errors = out.error_count();
  for (const auto& [first, second] : asked.named) add_named(first, second, items, list, out);
  if (list.pairs().empty() && out.error_count() == errors)
    out.error(asked.place, fmt::format("the cost '{}' has no pair of shapes", cost.name.value),
              spec.collision.shapes.empty() ? "the file has no 'collision: {shapes: ...}'" : "");
  return list.pairs();
}

}  // namespace conddp
