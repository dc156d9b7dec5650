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

HullSpec hull_of(const VisualShape& shape, const RobotSpec& robot, const Place& place,
                 const std::string& link, Diagnostics& out) {
  const std::filesystem::path file = find_mesh(shape.mesh, robot.path);
  const std::string what =
      fmt::format("the collision mesh '{}' of the link '{}'", shape.mesh, link);
  const std::string hint = fmt::format(
      "give the link a shape of your own: 'shapes: {{{}: {{frame: {}, ...}}}}'", link, link);
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

}  // namespace

void add_urdf_shapes(ProblemSpec& spec, Diagnostics& out) {
  if (!spec.collision.from_urdf) return;
  const Place& place = *spec.collision.from_urdf;
  std::vector<ShapeSpec>& shapes = spec.collision.shapes;
  for (const RobotSpec& robot : spec.robots) {
    const std::string prefix = robot.name.value.empty() ? "" : robot.name.value + "/";
    for (const LinkVisuals& link : urdf_visuals(read_text_file(robot.path, kMaxDataBytes).text)) {
      const std::string frame = prefix + link.link;
      for (std::size_t i = 0; i < link.collision.size(); ++i) {
        const VisualShape& shape = link.collision[i];
        const std::string name = i == 0 ? frame : fmt::format("{}/{}", frame, i + 1);
        if (shape.kind == ShapeKind::unknown ||
            std::ranges::any_of(shapes,
                                [&](const ShapeSpec& own) { return own.name.value == name; }))
          continue;
        Form form = shape.kind == ShapeKind::mesh ? hull_of(shape, robot, place, frame, out)
                                                  : form_of(shape);
        shapes.push_back({{name, place}, {frame, place}, std::move(form)});
      }
    }
  }
  spec.collision.from_urdf.reset();
}

}  // namespace conddp
