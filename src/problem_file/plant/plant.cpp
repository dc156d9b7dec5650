#include "problem_file/plant/plant.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"

namespace conddp {

const PlantPart& part_of(const Plant& plant, int joint) {
  return *std::find_if(plant.parts.begin(), plant.parts.end(), [&](const PlantPart& p) {
    return joint >= p.first_joint && joint < p.first_joint + p.joint_count;
  });
}

ComponentNames control_names(const Plant& plant) {
  ComponentNames names = control_names(plant.actuated());
  for (const Column& control : plant.controls)
    if (std::ranges::find(names.names, control.name) == names.names.end())
      names.elsewhere.push_back(control.name);
  return names;
}

bool is_independent(const RobotModel& robot, int joint) {
  const JointType type = robot.joints[joint].type;
  if (type == JointType::floating || type == JointType::parameter) return false;
  return std::none_of(robot.mimics.begin(), robot.mimics.end(),
                      [&](const Mimic& mimic) { return mimic.joint == joint; });
}

std::vector<std::string> joint_names(const RobotModel& robot) {
  std::vector<std::string> names;
  for (int i = 0; i < robot.joint_count(); ++i)
    if (is_independent(robot, i)) names.push_back(robot.joints[i].name);
  return names;
}

std::vector<std::string> frame_names(const RobotModel& robot) {
  std::vector<std::string> names;
  for (const Frame& frame : robot.frames) names.push_back(frame.name);
  return names;
}

SE3<double> placement_in_state(const MultibodySystem& system, const std::vector<double>& x,
                               int frame) {
  RobotData<double> data(system.robot());
  const std::vector<double> q =
      system.expand_configuration(std::vector(x.begin(), x.begin() + system.nq()));
  update_placements(system.robot(), q.data(), data);
  return frame_placement(system.robot(), data, frame);
}

RobotData<double> data_in_state(const MultibodySystem& system, const std::vector<double>& x) {
  RobotData<double> data(system.robot());
  const std::vector<double> q =
      system.expand_configuration(std::vector(x.begin(), x.begin() + system.nq()));
  const std::vector<double> v =
      system.expand_velocity(std::vector(x.begin() + system.nq(), x.end()));
  update_placements(system.robot(), q.data(), data);
  update_velocities(system.robot(), v.data(), data);
  return data;
}

std::optional<int> find_frame(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out) {
  const auto frame = robot.find_frame(prefix + name.value);
  if (!frame)
    out.error(name.place, fmt::format("the robot has no frame '{}'", prefix + name.value),
              name_hint(prefix + name.value, frame_names(robot), "frames"));
  return frame;
}

/// True for the frame of a planar joint, which moves as three joints of its name.
bool moves_as_three(const RobotModel& robot, const Frame& frame) {
  const auto last = robot.find_joint(frame.name + "_yaw");
  return last && frame.joint == *last && robot.find_joint(frame.name + "_x") &&
         robot.find_joint(frame.name + "_y");
}

std::optional<int> find_joint(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out) {
  const std::string full = prefix + name.value;
  const auto joint = robot.find_joint(full);
  if (joint && is_independent(robot, *joint)) return joint;
  if (joint && robot.joints[*joint].type == JointType::floating)
    out.error(name.place, fmt::format("'{}' is the floating base, not a joint", full));
  else if (joint && robot.joints[*joint].type == JointType::parameter)
    out.error(name.place, fmt::format("'{}' is a parameter, not a joint", full),
              name_hint(full, joint_names(robot), "joints"));
  else if (joint)
    out.error(name.place, fmt::format("the joint '{}' follows another one", full),
              "name the joint that it mimics, or write 'mimic: ignore'");
  else if (const auto planar = robot.find_frame(full);
           planar && moves_as_three(robot, robot.frames[*planar]))
    out.error(name.place, fmt::format("the planar joint '{}' moves as three joints", full),
              fmt::format("name '{0}_x', '{0}_y' and '{0}_yaw'", name.value));
  else if (const auto frame = robot.find_frame(full);
           frame && robot.frames[*frame].kind == FrameKind::joint)
    out.error(name.place, fmt::format("the joint '{}' does not move: it is fixed or locked", full),
              "leave it out here; 'locked_joints' says where a locked one is held");
  else
    out.error(name.place, fmt::format("the robot has no joint '{}'", full),
              name_hint(full, joint_names(robot), "joints"));
  return std::nullopt;
}

std::vector<int> find_joints(const RobotModel& robot, const Name& name, const std::string& prefix,
                             Diagnostics& out) {
  std::vector<int> found;
  if (!is_pattern(name.value)) {
    if (const auto joint = find_joint(robot, name, prefix, out)) found.push_back(*joint);
    return found;
  }
  const std::string full = prefix + name.value;
  for (int i = 0; i < robot.joint_count(); ++i)
    if (is_independent(robot, i) && fits(full, robot.joints[i].name)) found.push_back(i);
  if (found.empty())
    out.error(name.place, fmt::format("'{}' fits none of the joints", full),
              name_hint(full, joint_names(robot), "joints"));
  return found;
}

}  // namespace conddp
