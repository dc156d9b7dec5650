#include "output/scene/scene_obstacles.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "base/json/ordered_json.hpp"
#include "ocp/problem/by_name.hpp"
#include "output/scene/form_json.hpp"
#include "problem_file/assemble/problem_names.hpp"
#include "problem_file/plant/shape_pairs.hpp"

namespace conddp {
namespace {

Vector3<double> moved(const Vector3<double>& point, const SE3<double>& by) {
  return by.R * point + by.p;
}
SphereSpec moved(const SphereSpec& sphere, const SE3<double>& by) {
  return {sphere.radius, moved(sphere.center, by)};
}
CapsuleSpec moved(const CapsuleSpec& capsule, const SE3<double>& by) {
  return {capsule.radius, moved(capsule.from, by), moved(capsule.to, by)};
}
template <class Spec>
Polytope moved(const Spec& spec, const SE3<double>& by) {
  Polytope polytope = polytope_of(spec, -1);
  for (Vector3<double>& vertex : polytope.vertices) vertex = moved(vertex, by);
  return polytope;
}

template <class Shape>
OrderedJson shape_json(const Shape& shape) {
  OrderedJson json = {{"name", shape.name.value}};
  json.update(std::visit([](const auto& form) { return form_json(form); }, shape.form));
  return json;
}

/// A constraint on a position: its rows by axis, and its nodes.
struct OnPosition {
  std::string name;
  std::array<int, 3> row;  ///< of the residual, by axis; −1 without a row
  std::vector<NodeConstraint> at;

  int axes() const {
    return static_cast<int>(std::count_if(row.begin(), row.end(), [](int r) { return r >= 0; }));
  }
  /// The reference along an axis; 0 for an axis without a row.
  double reference(const ShootingProblem& problem, const NodeConstraint& c, int axis) const {
    return row[axis] < 0 ? 0 : problem.knot(c.node).parameters[c.term->parameters + row[axis]];
  }
  Vector3<double> center(const ShootingProblem& problem, const NodeConstraint& c) const {
    return {reference(problem, c, 0), reference(problem, c, 1), reference(problem, c, 2)};
  }
};

std::vector<OnPosition> constraints_on_positions(const BuiltProblem& built) {
  const ShootingProblem& problem = *built.problem;
  std::vector<OnPosition> list;
  for (const NodeConstraint& c : problem.constraints()) {
    if (!c.term->has_bounds()) continue;
    const std::string name = constraint_name(problem, c);
    const auto known = std::find_if(list.begin(), list.end(),
                                    [&](const OnPosition& one) { return one.name == name; });
    if (known != list.end()) {
      known->at.push_back(c);
      continue;
    }
    list.push_back({name, rows_by_axis(built, c), {c}});
  }
  std::erase_if(list, [](const OnPosition& one) { return one.axes() == 0; });
  return list;
}

/// Adds the center, at each node if it moves.
void add_centers(const OnPosition& one, const ShootingProblem& problem, OrderedJson& json) {
  const Vector3<double> center = one.center(problem, one.at.front());
  bool moves = false;
  OrderedJson centers = OrderedJson::array();
  auto next = one.at.begin();
  for (int k = 0; k <= problem.knots(); ++k) {  // other nodes: the next center
    while (next + 1 != one.at.end() && next->node < k) ++next;
    const Vector3<double> here = one.center(problem, *next);
    moves |= squared_norm(here - center) > 0;
    for (const double x : {here.x, here.y, here.z}) centers.push_back(eight_digits(x));
  }
  if (moves)
    json["centers"] = std::move(centers);
  else
    json["center"] = coordinates_json(center);
}

/// The normal of a disc: the axis without a row.
OrderedJson normal_json(const OnPosition& one) {
  OrderedJson json = OrderedJson::array();
  for (const int row : one.row) json.push_back(row < 0 ? 1 : 0);
  return json;
}

/// Spheres and discs that a position must stay outside or inside.
void append_round(const OnPosition& one, const ShootingProblem& problem, OrderedJson& list) {
  const NodeConstraint& first = one.at.front();
  const int axes = one.axes();
  if (axes < 2 || axes != first.term->residual->size()) return;
  OrderedJson json = {{"name", one.name}, {"kind", axes == 3 ? "sphere" : "disc"}};
  add_centers(one, problem, json);
  if (axes == 2) json["normal"] = normal_json(one);
  for (const bool inside : {false, true}) {
    const double radius = inside ? *first.upper : *first.lower;
    if (!(radius > 0) || std::isinf(radius)) continue;
    json["radius"] = radius;
    json["inside"] = inside;
    list.push_back(json);
  }
}

bool moves_along(const OnPosition& one, const ShootingProblem& problem, int axis) {
  const double from = one.reference(problem, one.at.front(), axis);
  return std::any_of(one.at.begin(), one.at.end(), [&](const NodeConstraint& c) {
    return one.reference(problem, c, axis) != from;
  });
}

void append_box(const OnPosition& one, const ShootingProblem& problem, OrderedJson& list) {
  std::array<OrderedJson, 2> ends = {OrderedJson::array(), OrderedJson::array()};
  bool bounded = false;
  for (int axis = 0; axis < 3; ++axis) {
    if (moves_along(one, problem, axis)) return;
    const int row = one.row[axis];
    const double from = one.reference(problem, one.at.front(), axis);
    for (int upper = 0; upper < 2; ++upper) {
      double end = upper ? kUnlimited : -kUnlimited;
      if (row >= 0) end = from + (upper ? one.at.front().upper : one.at.front().lower)[row];
      bounded |= std::isfinite(end);
      ends[upper].push_back(finite_or_null(end));
    }
  }
  if (bounded)
    list.push_back({{"name", one.name},
                    {"kind", "box"},
                    {"lower", ends[0]},
                    {"upper", ends[1]},
                    {"inside", true}});
}

}  // namespace

OrderedJson obstacles_json(const BuiltProblem& built) {
  OrderedJson list = OrderedJson::array();
  for (const ObstacleSpec& obstacle : built.facts().collision.obstacles) {
    list.push_back(shape_json(obstacle));
    list.back()["inside"] = false;
  }
  for (const TerrainPieceSpec& piece : built.facts().terrain) {
    list.push_back(shape_json(piece));
    list.back()["terrain"] = true;
  }
  for (const OnPosition& one : constraints_on_positions(built))
    if (one.at.front().term->kind == ConstraintKind::norm)
      append_round(one, *built.problem, list);
    else
      append_box(one, *built.problem, list);
  return list;
}

OrderedJson collision_shapes_json(const CollisionSpec& collision, const RobotModel& robot) {
  OrderedJson list = OrderedJson::array();
  for (const ShapeSpec& shape : collision.shapes) {
    const Frame& frame = robot.frames[robot.find_frame(shape.frame.value).value()];
    list.push_back({{"name", shape.name.value}});
    list.back().update(std::visit(
        [&](const auto& form) { return form_json(moved(form, frame.placement)); }, shape.form));
    list.back()["body"] = frame.joint + 1;
  }
  return list;
}

}  // namespace conddp
