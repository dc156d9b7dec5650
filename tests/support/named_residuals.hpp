#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ocp/knot_model.hpp"
#include "ocp/residuals.hpp"

namespace conddp {

/// Every residual that a robot's knots can have, by name: what tests of all residuals run through.
/// A new residual is one more line here. Of the frames every `frame_step`-th one.
inline std::vector<std::pair<std::string, std::shared_ptr<const Residual>>> named_residuals(
    const std::shared_ptr<const MultibodySystem>& system, const KnotModel& model,
    int frame_step = 1) {
  const RobotModel& robot = system->robot();
  std::vector<int> positions, velocities, rows;
  for (int joint = 0; joint < robot.joint_count(); ++joint) {
    if (robot.joints[joint].type == JointType::floating || !system->position_index(joint)) continue;
    positions.push_back(*system->position_index(joint));
    velocities.push_back(*system->velocity_index(joint));
    rows.push_back(*system->velocity_row(joint));
  }
  std::vector<std::pair<std::string, std::shared_ptr<const Residual>>> all = {
      {"state", state_residual(model.manifold())},
      {"positions", coordinate_residual(model.manifold(), positions)},
      {"velocities", coordinate_residual(model.manifold(), velocities)},
      {"control", control_residual(model.ndx(), model.nu())},
      {"acceleration", acceleration_residual(*system, model.ndx(), rows)},
      {"com", com_position_residual(system)},
      {"control_gravity", control_gravity_residual(system, model.ndx())}};
  if (model.has_control_memory()) all.emplace_back("rate", control_rate_residual(*system));
  for (int f = 0; f < static_cast<int>(robot.frames.size()); f += frame_step) {
    const std::string& name = robot.frames[f].name;
    all.emplace_back("position " + name, frame_position_residual(system, f));
    all.emplace_back("rotation " + name, frame_rotation_residual(system, f));
    all.emplace_back("placement " + name, frame_placement_residual(system, f));
    all.emplace_back("velocity " + name, frame_velocity_residual(system, f, FrameAxes::local));
    all.emplace_back("world velocity " + name,
                     frame_velocity_residual(system, f, FrameAxes::world_aligned));
  }
  return all;
}

}  // namespace conddp
