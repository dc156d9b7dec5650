#include "output/scene/robot_shapes.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>
#include <fmt/format.h>

#include "base/files/text_file.hpp"
#include "output/scene/scene_meshes.hpp"
#include "output/scene/scene_numbers.hpp"
#include "robot/urdf/urdf_meshes.hpp"
#include "robot/urdf/urdf_visuals.hpp"

namespace conddp {
namespace {

constexpr std::size_t kMaxUrdfBytes = 64 << 20;
/// kg/m³: minimum density of real links. Placeholder inertias have lighter ellipsoids.
constexpr double kLeastDensity = 10;
constexpr double kLeastRadius = 0.005;  // m

/// The ellipsoid with a body's mass and inertia: ½ axes √(5 (I_b + I_c − I_a) / (2 m)).
OrderedJson inertia_ellipsoid(const Inertia<double>& inertia, const SE3<double>& frame) {
  const Vector3<double> com = (1 / inertia.mass) * inertia.moment;
  const Symmetric3<double> at_origin = inertia.rotational,
                           of_point = point_inertia(inertia.mass, com);
  Eigen::Matrix3d central;
  central << at_origin.xx - of_point.xx, at_origin.xy - of_point.xy, at_origin.xz - of_point.xz,
      at_origin.xy - of_point.xy, at_origin.yy - of_point.yy, at_origin.yz - of_point.yz,
      at_origin.xz - of_point.xz, at_origin.yz - of_point.yz, at_origin.zz - of_point.zz;
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver(central);
  Eigen::Matrix3d axes = solver.eigenvectors();
  if (axes.determinant() < 0) axes.col(2) = -axes.col(2);
  Matrix3<double> rotation;
  Eigen::Vector3d radii;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rotation.m[3 * i + j] = axes(i, j);
    const double square = solver.eigenvalues().sum() - 2 * solver.eigenvalues()[i];
    radii[i] = std::sqrt(std::max(0.0, 2.5 * square / inertia.mass));
  }
  const double volume = 4 * M_PI / 3 * radii.prod(), largest = inertia.mass / kLeastDensity;
  if (volume > largest) radii *= std::cbrt(largest / volume);
  radii = radii.cwiseMax(kLeastRadius);
  return {{"kind", "ellipsoid"},
          {"radii", vector_json({radii[0], radii[1], radii[2]})},
          {"placement", placement_json(frame * SE3<double>{rotation, com})}};
}

/// Reads the shapes of one robot into the bodies that carry them.
class ShapeReader {
 public:
  ShapeReader(const RobotModel& robot, RobotShapes& out, SceneMeshes& meshes)
      : robot_(robot), out_(out), meshes_(meshes) {}

  void read(const PlantPart& part) {
    urdf_ = part.spec->path;
    const TextFile urdf = read_text_file(urdf_, kMaxUrdfBytes);
    for (const LinkVisuals& link : urdf_visuals(urdf.text))
      if (const auto frame = robot_.find_frame(part.prefix + link.link))
        draw(link, robot_.frames[*frame]);
  }

 private:
  /// The first drawable kind of shapes and its name, with the reasons why some visual shapes cannot
  /// be drawn.
  std::pair<OrderedJson, const char*> shapes_of(const LinkVisuals& link, const Frame& frame,
                                                OrderedJson& reasons) {
    OrderedJson shapes = drawable(link.visual, frame, reasons);
    if (link.visual.empty()) reasons.push_back({{"why", "no visual shape"}, {"what", ""}});
    if (!shapes.empty()) return {std::move(shapes), "other visual shapes"};
    OrderedJson ignored = OrderedJson::array();
    shapes = drawable(link.collision, frame, ignored);
    if (!shapes.empty()) return {std::move(shapes), "collision shape"};
    if (!link.inertia) return {std::move(shapes), "nothing"};
    shapes.push_back(inertia_ellipsoid(*link.inertia, frame.placement));
    return {std::move(shapes), "inertia ellipsoid"};
  }

  void draw(const LinkVisuals& link, const Frame& frame) {
    OrderedJson reasons = OrderedJson::array();
    auto [shapes, drawn_by] = shapes_of(link, frame, reasons);
    OrderedJson& body = out_.of_body[frame.joint + 1];
    for (OrderedJson& shape : shapes) {
      shape["link"] = frame.name;
      body.push_back(std::move(shape));
    }
    // A link without shapes and inertia is only a frame and has nothing to draw.
    if (reasons.empty() || (shapes.empty() && link.visual.empty() && link.collision.empty()))
      return;
    out_.stand_ins.push_back(
        {{"link", frame.name}, {"drawn_by", drawn_by}, {"reasons", std::move(reasons)}});
  }

  /// The drawable shapes; `reasons` receives the reasons for the others.
  OrderedJson drawable(const std::vector<VisualShape>& shapes, const Frame& frame,
                       OrderedJson& reasons) {
    OrderedJson list = OrderedJson::array();
    for (const VisualShape& shape : shapes) {
      std::string why;
      OrderedJson json = shape_json(shape, why);
      if (json.is_null()) {
        reasons.push_back({{"why", why}, {"what", shape.mesh}});
        continue;
      }
      json["placement"] = placement_json(frame.placement * shape.placement);
      if (shape.color) json["color"] = *shape.color;
      list.push_back(std::move(json));
    }
    return list;
  }

  OrderedJson shape_json(const VisualShape& shape, std::string& why) {
    switch (shape.kind) {
      case ShapeKind::box:
        return {{"kind", "box"}, {"size", vector_json(shape.size)}};
      case ShapeKind::cylinder:
        return {{"kind", "cylinder"}, {"radius", shape.size.x}, {"length", shape.size.y}};
      case ShapeKind::sphere:
        return {{"kind", "sphere"}, {"radius", shape.size.x}};
      case ShapeKind::mesh:
        return mesh_json(shape, why);
      case ShapeKind::unknown:
        break;
    }
    why = shape.mesh.empty() ? "no geometry" : "geometry not read";
    return nullptr;
  }

  OrderedJson mesh_json(const VisualShape& shape, std::string& why) {
    why = "mesh format not read";
    if (mesh_kind(shape.mesh).empty()) return nullptr;
    const auto mesh = meshes_.add(find_mesh(shape.mesh, urdf_), why);
    if (!mesh) return nullptr;
    return {{"kind", "mesh"}, {"mesh", *mesh}, {"scale", vector_json(shape.size)}};
  }

  const RobotModel& robot_;
  RobotShapes& out_;
  SceneMeshes& meshes_;
  std::filesystem::path urdf_;
};

}  // namespace

RobotShapes robot_shapes(const BuiltProblem& built) {
  const RobotModel& robot = built.plant.robot();
  RobotShapes shapes;
  shapes.of_body.assign(robot.joints.size() + 1, OrderedJson::array());
  SceneMeshes meshes;
  ShapeReader reader(robot, shapes, meshes);
  for (const PlantPart& part : built.plant.parts) reader.read(part);
  shapes.meshes = meshes.json();
  // Masses that the problem file adds to links without shapes.
  for (int i = 0; i < robot.joint_count(); ++i)
    if (shapes.of_body[i + 1].empty() && robot.joints[i].inertia.mass > 0)
      shapes.of_body[i + 1].push_back(
          inertia_ellipsoid(robot.joints[i].inertia, SE3<double>::identity()));
  return shapes;
}

}  // namespace conddp
