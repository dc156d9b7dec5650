#include "problem_file/lower/urdf_shapes.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/files/text_file.hpp"
#include "problem_file/data/mesh_hull.hpp"
#include "robot/urdf/urdf_meshes.hpp"
#include "robot/urdf/urdf_visuals.hpp"

namespace conddp {
namespace {

using Form = decltype(ShapeSpec::form);

std::string hint_of(const std::string& link) {
  return fmt::format("give the link a shape of your own: 'shapes: {{{0}: {{frame: {0}, ...}}}}'",
                     link);
}

HullSpec hull_of(const VisualShape& shape, const RobotSpec& robot, const Place& place,
                 const std::string& link, Diagnostics& out) {
  const std::filesystem::path file = find_mesh(shape.mesh, robot.path);
  const std::string what =
      fmt::format("the collision mesh '{}' of the link '{}'", shape.mesh, link);
  const std::string hint = hint_of(link);
  if (file.empty()) return out.error(place, what + " is not found", hint), HullSpec();
  std::string defect;
  HullSpec hull = mesh_hull(file, shape.size, defect, out);
  if (!defect.empty()) out.error(place, fmt::format("{}: {}", what, defect), hint);
  hull.placement = {{}, shape.placement.p, quaternion(shape.placement.R)};
  return hull;
}

Form form_of(const VisualShape& shape) {
  const SE3<double>& placement = shape.placement;
  if (shape.kind == ShapeKind::sphere) return SphereSpec{shape.size.x, placement.p};
  if (shape.kind == ShapeKind::box)
    return BoxSpec{shape.size, {{}, placement.p, quaternion(placement.R)}};
  const Vector3<double> half = (0.5 * shape.size.y) * placement.R.column(2);
  return CylinderSpec{shape.size.x, placement.p - half, placement.p + half};
}

/// Adds the shapes of a robot; true if its URDF has any.
bool add_shapes(const RobotSpec& robot, const Place& place, CollisionSpec& collision,
                Diagnostics& out) {
  const auto named = [](const auto& list, const std::string& name) {
    return std::ranges::find_if(list, [&](const auto& own) { return own.name.value == name; });
  };
  const std::string prefix = robot.name.value.empty() ? "" : robot.name.value + "/";
  bool any = false;
  for (const LinkVisuals& link : urdf_visuals(read_text_file(robot.path, kMaxDataBytes).text)) {
    const std::string frame = prefix + link.link;
    for (std::size_t i = 0; i < link.collision.size(); ++i) {
      const VisualShape& shape = link.collision[i];
      const std::string name = i == 0 ? frame : fmt::format("{}/{}", frame, i + 1);
      any = true;
      if (named(collision.shapes, name) != collision.shapes.end()) continue;
      if (const auto obstacle = named(collision.obstacles, name);
          obstacle != collision.obstacles.end())
        out.error(obstacle->name.place,
                  fmt::format("a shape of the URDF and an obstacle have the name '{}'", name));
      if (shape.kind == ShapeKind::unknown) {
        out.warning(
            place,
            fmt::format("the collision shape '{}' of the link '{}' is not read", shape.mesh, frame),
            hint_of(frame));
        continue;
      }
      Form form =
          shape.kind == ShapeKind::mesh ? hull_of(shape, robot, place, frame, out) : form_of(shape);
      collision.shapes.push_back({{name, place}, {frame, place}, std::move(form)});
    }
  }
  return any;
}

}  // namespace

void add_urdf_shapes(ProblemSpec& spec, Diagnostics& out) {
  if (!spec.collision.from_urdf) return;
  const Place& place = *spec.collision.from_urdf;
  bool any = false;
  for (const RobotSpec& robot : spec.robots) any |= add_shapes(robot, place, spec.collision, out);
  if (!any)
    out.error(place, "the URDF has no collision shape",
              "give shapes of your own: 'shapes: {NAME: {frame: LINK, capsule: ...}}'");
  spec.collision.from_urdf.reset();
}

}  // namespace conddp
