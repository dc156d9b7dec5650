#include "output/scene/motion_scene.hpp"

#include "output/scene/closed_form_scene.hpp"
#include "output/scene/drawings.hpp"
#include "output/scene/robot_shapes.hpp"
#include "output/scene/scene_numbers.hpp"
#include "output/scene/scene_obstacles.hpp"
#include "problem_file/assemble/problem_names.hpp"
#include "problem_file/motion/terrain.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"

namespace conddp {
namespace {

OrderedJson bodies_json(const RobotModel& robot, std::vector<OrderedJson>&& shapes) {
  OrderedJson bodies = OrderedJson::array();
  bodies.push_back({{"name", "world"}, {"parent", nullptr}, {"shapes", std::move(shapes[0])}});
  for (std::size_t i = 0; i < robot.joints.size(); ++i)
    bodies.push_back({{"name", robot.joints[i].name},
                      {"parent", robot.joints[i].parent + 1},
                      {"shapes", std::move(shapes[i + 1])}});
  return bodies;
}

/// Unit normal of a contact in the world: that of the terrain below, except for walls and ceilings.
Vector3<double> world_normal(const ContactSpec& contact, const SE3<double>& frame,
                             const TerrainSpec& terrain) {
  if (contact.axes == FrameAxes::local) return frame.R * contact.normal;
  const auto ground =
      contact.normal.z > 0 ? ground_at(terrain, frame.p.x, frame.p.y) : std::nullopt;
  return ground ? ground->normal : contact.normal;
}

/// A contact between two frames has no ground, and no cone about a normal of the world.
OrderedJson contact_json(const ContactSpec& contact, const Frame& frame) {
  const bool slips = contact.kind != ContactKind::normal && !contact.to;
  OrderedJson json = {{"name", contact.name.value},
                      {"body", frame.joint + 1},
                      {"placement", placement_json(frame.placement)},
                      {"friction", slips ? contact.friction : 0},
                      {"half_size", nullptr},
                      {"radius", 0},
                      {"acts_after", 0},
                      {"ground", !contact.to},
                      {"positions", OrderedJson::array()},
                      {"normals", OrderedJson::array()}};
  if (contact.half_size) json["half_size"] = *contact.half_size;
  return json;
}

/// Appends the poses of the world and of all bodies.
void append_bodies(const RobotModel& robot, const RobotData<double>& data, OrderedJson& poses) {
  append(poses, SE3<double>::identity());
  for (int j = 0; j < robot.joint_count(); ++j)
    append(poses, data.root_pose(robot, j) * data.placement[j]);
}

/// A scene with no body but the world.
OrderedJson empty_scene(int nodes) {
  OrderedJson poses = OrderedJson::array();
  for (int k = 0; k < nodes; ++k) append(poses, SE3<double>::identity());
  OrderedJson world = {{"name", "world"}, {"parent", nullptr}, {"shapes", OrderedJson::array()}};
  return {{"bodies", OrderedJson::array({std::move(world)})},
          {"poses", std::move(poses)},
          {"com", OrderedJson::array()},
          {"paths", OrderedJson::object()},
          {"contacts", OrderedJson::array()}};
}

OrderedJson system_scene(const BuiltProblem& built, const Trajectory& trajectory) {
  OrderedJson scene = closed_form_scene(*built.facts().system, trajectory);
  if (scene.is_null() && built.drawn) scene = empty_scene(trajectory.knots() + 1);
  if (!scene.is_null()) scene["obstacles"] = obstacles_json(built);
  return scene;
}

OrderedJson robot_scene(const BuiltProblem& built, const Trajectory& trajectory) {
  const ProblemFacts& facts = built.facts();
  const MultibodySystem& system = *built.plant.multibody();
  const RobotModel& robot = built.plant.robot();
  OrderedJson poses = OrderedJson::array(), com = OrderedJson::array();
  OrderedJson paths = OrderedJson::object(), contacts = OrderedJson::array();
  const std::map<std::string, int> watched = watched_frames(built);
  for (const auto& [name, frame] : watched) paths[name] = OrderedJson::array();
  std::vector<int> contact_frames;
  for (const ContactSpec& contact : facts.contacts) {
    contact_frames.push_back(robot.find_frame(contact.frame.value).value());
    contacts.push_back(contact_json(contact, robot.frames[contact_frames.back()]));
  }

  RobotData<double> data(robot);
  for (int k = 0; k <= trajectory.knots(); ++k) {
    const std::vector<double> q =
        system.expand_configuration({trajectory.x(k).data(), trajectory.x(k).data() + system.nq()});
    update_placements(robot, q.data(), data);
    update_composite_inertias(robot, data);
    append(com, center_of_mass(robot, data));
    append_bodies(robot, data, poses);
    for (const auto& [name, frame] : watched)
      append(paths[name], frame_placement(robot, data, frame).p);
    for (std::size_t i = 0; i < facts.contacts.size(); ++i) {
      const SE3<double> placement = frame_placement(robot, data, contact_frames[i]);
      append(contacts[i]["positions"], placement.p);
      append(contacts[i]["normals"], world_normal(facts.contacts[i], placement, facts.terrain));
    }
  }
  RobotShapes shapes = robot_shapes(built);
  return {{"bodies", bodies_json(robot, std::move(shapes.of_body))},
          {"meshes", std::move(shapes.meshes)},
          {"stand_ins", std::move(shapes.stand_ins)},
          {"poses", std::move(poses)},
          {"com", std::move(com)},
          {"paths", std::move(paths)},
          {"contacts", std::move(contacts)},
          {"obstacles", obstacles_json(built)},
          {"collision_shapes", collision_shapes_json(facts.collision, robot)}};
}

}  // namespace

OrderedJson motion_scene(const BuiltProblem& built, const Trajectory& trajectory,
                         std::span<const int> knots) {
  OrderedJson scene =
      built.plant.multibody() ? robot_scene(built, trajectory) : system_scene(built, trajectory);
  if (built.drawn) add_drawings(built, trajectory, knots, scene);
  return scene;
}

}  // namespace conddp
