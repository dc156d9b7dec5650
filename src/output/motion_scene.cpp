#include "output/motion_scene.hpp"

#include <cmath>
#include <map>
#include <set>

#include <Eigen/Eigenvalues>
#include <openssl/evp.h>

#include "output/closed_form_scene.hpp"
#include "output/scene_obstacles.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"
#include "robot/text_file.hpp"
#include "robot/urdf_visuals.hpp"

namespace conddp {
namespace {

constexpr std::size_t kMaxUrdfBytes = 64 << 20;
/// Of all meshes together: a page of more opens slowly.
constexpr std::size_t kMaxMeshBytes = 3 << 20;

double micrometres(double x) {
  if (!std::isfinite(x)) return x;
  const double rounded = std::round(x * 1e6) / 1e6;
  return rounded == 0 ? 0 : rounded;  // no -0
}

void append(OrderedJson& list, const Vector3<double>& v) {
  for (const double x : {v.x, v.y, v.z}) list.push_back(finite_or_null(micrometres(x)));
}

void append(OrderedJson& list, const SE3<double>& placement) {
  append(list, placement.p);
  const Quaternion<double> q = quaternion(placement.R);
  for (const double x : {q.x, q.y, q.z, q.w}) list.push_back(finite_or_null(micrometres(x)));
}

OrderedJson vector_json(const Vector3<double>& v) {
  OrderedJson list = OrderedJson::array();
  append(list, v);
  return list;
}

OrderedJson placement_json(const SE3<double>& placement) {
  OrderedJson list = OrderedJson::array();
  append(list, placement);
  return list;
}

std::string base64(const std::string& bytes) {
  std::string text(4 * ((bytes.size() + 2) / 3) + 1, '\0');  // EVP_EncodeBlock ends it with a zero
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  EVP_EncodeBlock(reinterpret_cast<unsigned char*>(text.data()), data,
                  static_cast<int>(bytes.size()));
  text.pop_back();
  return text;
}

/// Where a mesh of a URDF is: beside the URDF, or for package://name/path in a folder `name` of
/// those above it.
std::filesystem::path find_mesh(const std::string& name, const std::filesystem::path& urdf) {
  const std::filesystem::path folder = urdf.parent_path();
  const auto exists = [](const std::filesystem::path& file) {
    std::error_code error;
    return std::filesystem::is_regular_file(file, error);
  };
  constexpr std::string_view kFile = "file://", kPackage = "package://";
  if (name.starts_with(kFile))
    return exists(name.substr(kFile.size())) ? name.substr(kFile.size()) : "";
  if (!name.starts_with(kPackage)) return exists(folder / name) ? folder / name : "";
  const std::filesystem::path inside = name.substr(kPackage.size());
  if (inside.empty()) return {};
  // Of the file: a file in the current folder has a folder without a name.
  std::filesystem::path base = std::filesystem::absolute(urdf).parent_path();
  for (int up = 0; up < 6; ++up, base = base.parent_path()) {
    if (exists(base / inside)) return base / inside;
    const std::filesystem::path rest = inside.lexically_relative(*inside.begin());
    if (base.filename() == *inside.begin() && exists(base / rest)) return base / rest;
  }
  return {};
}

/// Reads the shapes of one robot into the bodies that carry them.
class ShapeReader {
 public:
  ShapeReader(const RobotModel& robot, OrderedJson& bodies) : robot_(robot), bodies_(bodies) {}

  void read(const PlantPart& part) {
    const TextFile urdf = read_text_file(part.spec->path, kMaxUrdfBytes);
    for (const VisualShape& shape : urdf_visuals(urdf.text)) {
      const auto frame = robot_.find_frame(part.prefix + shape.link);
      if (!frame) continue;
      const Frame& link = robot_.frames[*frame];
      OrderedJson json = shape_json(shape, part.spec->path);
      if (json.is_null()) continue;
      json["placement"] = placement_json(link.placement * shape.placement);
      bodies_[link.joint + 1]["shapes"].push_back(std::move(json));
    }
  }

 private:
  OrderedJson shape_json(const VisualShape& shape, const std::filesystem::path& urdf) {
    OrderedJson json = {{"link", shape.link}};
    switch (shape.kind) {
      case ShapeKind::box:
        json["kind"] = "box";
        json["size"] = vector_json(shape.size);
        break;
      case ShapeKind::cylinder:
        json["kind"] = "cylinder";
        json["radius"] = shape.size.x;
        json["length"] = shape.size.y;
        break;
      case ShapeKind::sphere:
        json["kind"] = "sphere";
        json["radius"] = shape.size.x;
        break;
      case ShapeKind::mesh: {
        const std::filesystem::path file = find_mesh(shape.mesh, urdf);
        std::string suffix = file.extension().string();
        for (char& c : suffix) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        if (suffix != ".stl" && suffix != ".obj") return nullptr;
        const TextFile mesh = read_text_file(file, kMaxMeshBytes - mesh_bytes_);
        if (!mesh.defect.empty()) return nullptr;
        mesh_bytes_ += mesh.text.size();
        json["kind"] = suffix.substr(1);
        json["scale"] = vector_json(shape.size);
        json["data"] = base64(mesh.text);
        break;
      }
    }
    if (shape.color) json["color"] = *shape.color;
    return json;
  }

  const RobotModel& robot_;
  OrderedJson& bodies_;
  std::size_t mesh_bytes_ = 0;
};

/// The ellipsoid that has a body's mass and inertia: ½ axes √(5 (I_b + I_c − I_a) / (2 m)).
OrderedJson inertia_ellipsoid(const Inertia<double>& inertia) {
  if (inertia.mass <= 0) return nullptr;
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
  Vector3<double> radii;
  double* const radius[] = {&radii.x, &radii.y, &radii.z};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) rotation.m[3 * i + j] = axes(i, j);
    const double square = solver.eigenvalues().sum() - 2 * solver.eigenvalues()[i];
    *radius[i] = std::max(0.005, std::sqrt(std::max(0.0, 2.5 * square / inertia.mass)));
  }
  return {{"kind", "ellipsoid"},
          {"radii", vector_json(radii)},
          {"placement", placement_json({rotation, com})}};
}

OrderedJson bodies_json(const BuiltProblem& built) {
  const RobotModel& robot = built.plant.robot();
  OrderedJson bodies = OrderedJson::array();
  bodies.push_back({{"name", "world"}, {"parent", nullptr}, {"shapes", OrderedJson::array()}});
  for (const Joint& joint : robot.joints)
    bodies.push_back(
        {{"name", joint.name}, {"parent", joint.parent + 1}, {"shapes", OrderedJson::array()}});
  ShapeReader reader(robot, bodies);
  for (const PlantPart& part : built.plant.parts) reader.read(part);
  for (int i = 0; i < robot.joint_count(); ++i) {
    OrderedJson& shapes = bodies[i + 1]["shapes"];
    if (!shapes.empty()) continue;
    OrderedJson ellipsoid = inertia_ellipsoid(robot.joints[i].inertia);
    if (!ellipsoid.is_null()) shapes.push_back(std::move(ellipsoid));
  }
  return bodies;
}

/// Frames whose way is worth seeing: those that costs and constraints speak of, but those of
/// contacts, whose ways are drawn anyway.
std::map<std::string, int> watched_frames(const ProblemSpec& spec, const RobotModel& robot) {
  std::map<std::string, int> frames;
  const auto watch = [&](const CostSpec& cost) {
    if (!cost.frame) return;
    if (const auto frame = robot.find_frame(cost.frame->value)) frames[cost.frame->value] = *frame;
  };
  for (const auto* costs : {&spec.costs, &spec.terminal_costs})
    for (const CostSpec& cost : *costs) watch(cost);
  for (const auto* constraints : {&spec.constraints, &spec.terminal_constraints})
    for (const ConstraintSpec& constraint : *constraints) watch(constraint.function);
  for (const ContactSpec& contact : spec.contacts) frames.erase(contact.frame.value);
  return frames;
}

/// Unit normal of a contact in the world.
Vector3<double> world_normal(const ContactSpec& contact, const SE3<double>& frame) {
  return contact.axes == FrameAxes::local ? frame.R * contact.normal : contact.normal;
}

OrderedJson contact_json(const ContactSpec& contact, const Frame& frame) {
  OrderedJson json = {{"name", contact.name.value},
                      {"body", frame.joint + 1},
                      {"placement", placement_json(frame.placement)},
                      {"friction", contact.kind == ContactKind::normal ? 0 : contact.friction},
                      {"half_size", nullptr},
                      {"positions", OrderedJson::array()},
                      {"normals", OrderedJson::array()}};
  if (contact.half_size) json["half_size"] = *contact.half_size;
  return json;
}

}  // namespace

OrderedJson motion_scene(const ProblemSpec& spec, const BuiltProblem& built,
                         const Trajectory& trajectory) {
  if (!built.plant.multibody) {
    OrderedJson scene = closed_form_scene(*spec.system, trajectory);
    if (!scene.is_null()) scene["obstacles"] = obstacles_json(spec, built);
    return scene;
  }
  const MultibodySystem& system = *built.plant.multibody;
  const RobotModel& robot = built.plant.robot();
  OrderedJson poses = OrderedJson::array(), com = OrderedJson::array();
  OrderedJson paths = OrderedJson::object(), contacts = OrderedJson::array();
  const std::map<std::string, int> watched = watched_frames(spec, robot);
  for (const auto& [name, frame] : watched) paths[name] = OrderedJson::array();
  std::vector<int> contact_frames;
  for (const ContactSpec& contact : spec.contacts) {
    contact_frames.push_back(robot.find_frame(contact.frame.value).value());
    contacts.push_back(contact_json(contact, robot.frames[contact_frames.back()]));
  }

  RobotData<double> data(robot);
  for (int k = 0; k <= trajectory.knots(); ++k) {
    const std::vector<double> q =
        system.expand_configuration({trajectory.x(k).data(), trajectory.x(k).data() + system.nq()});
    update_placements(robot, q.data(), data);
    Vector3<double> moment = Vector3<double>::zero();
    append(poses, SE3<double>::identity());
    for (int j = 0; j < robot.joint_count(); ++j) {
      const SE3<double> body = data.root_pose(robot, j) * data.placement[j];
      const Inertia<double>& inertia = robot.joints[j].inertia;
      moment = moment + inertia.mass * body.p + body.R * inertia.moment;
      append(poses, body);
    }
    append(com, (1 / robot.total_mass()) * moment);
    for (const auto& [name, frame] : watched)
      append(paths[name], frame_placement(robot, data, frame).p);
    for (std::size_t i = 0; i < spec.contacts.size(); ++i) {
      const SE3<double> placement = frame_placement(robot, data, contact_frames[i]);
      append(contacts[i]["positions"], placement.p);
      append(contacts[i]["normals"], world_normal(spec.contacts[i], placement));
    }
  }
  return {{"bodies", bodies_json(built)},
          {"poses", std::move(poses)},
          {"com", std::move(com)},
          {"paths", std::move(paths)},
          {"contacts", std::move(contacts)},
          {"obstacles", obstacles_json(spec, built)},
          {"collision_shapes", collision_shapes_json(spec, robot)}};
}

}  // namespace conddp
