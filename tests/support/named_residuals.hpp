#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "ocp/knot/knot_model.hpp"
#include "ocp/residuals/residuals.hpp"
#include "ocp/residuals/weighted_residual.hpp"

namespace conddp {

/// Shape pairs of every kind, also overlapping ones: on each `frame_step`-th frame with shapes of
/// the world and of another frame. A fixed frame has a pair too.
inline std::vector<DistancePair> distance_pairs(const RobotModel& robot, int frame_step = 1) {
  std::vector<DistancePair> pairs;
  const int n = static_cast<int>(robot.frames.size());
  for (int f = 0; f < n; f += frame_step) {
    const Capsule capsule{f, {0.1, -0.05, 0.2}, {-0.1, 0.1, 0.05}, 0.04};
    const Capsule sphere{f, {0.1, 0.2, -0.1}, {0.1, 0.2, -0.1}, 0.1};
    const Capsule world{-1, {0.3, 0.1, -0.2}, {0.1, 0.3, 0.4}, 0.03};
    const Capsule point{-1, {0.3, 0.1, 0.2}, {0.3, 0.1, 0.2}, 0.05};
    pairs.push_back({capsule, world});
    pairs.push_back({sphere, world});
    pairs.push_back({capsule, point});
    pairs.push_back({capsule, HalfSpace{{0.36, -0.48, 0.8}, 0.1}});
    pairs.push_back({sphere, HalfSpace{{0, 0, 1}, -0.2}});
    const Polytope wedge{f, {{0, 0, 0}, {0.2, 0, 0.1}, {0, 0.3, 0.1}, {0.1, 0.1, 0.4}}, 0.02};
    const Polytope stone{-1, {{0.9, 0, 0}, {1.2, 0.3, 0}, {1, 0.4, 0.5}, {1, -0.2, 0.6}}, 0};
    pairs.push_back({wedge, stone});
    pairs.push_back({wedge, stone, 0.05});
    pairs.push_back({capsule, stone, 0.05});
    pairs.push_back({wedge, point});
    pairs.push_back({sphere, stone, 0.0});
    pairs.push_back({wedge, HalfSpace{{0.36, -0.48, 0.8}, 0.1}});
    const int other = (f + 1 + f / 2) % n;
    if (other == f) continue;
    pairs.push_back({capsule, Capsule{other, {-0.1, 0, 0.1}, {0.2, 0.05, 0}, 0.05}});
    pairs.push_back({sphere, Capsule{other, {0, 0, 0.1}, {0, 0, 0.1}, 0.05}});
    pairs.push_back({wedge, Capsule{other, {-0.1, 0, 0.1}, {0.2, 0.05, 0}, 0.05}});
  }
  return pairs;
}

/// Every residual of a robot's knots by name, for tests that cover all residuals; a new residual
/// adds a line here. Uses every `frame_step`-th frame.
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
      {"control_gravity", control_gravity_residual(system, model.ndx())},
      {"momentum", centroidal_momentum_residual(system)},
      {"distance", distance_residual(system, distance_pairs(robot, frame_step))}};
  for (const auto& segment : model.manifold().segments())
    if (segment.part == StateManifold::Part::se3)
      all.emplace_back("position of a pose",
                       coordinate_residual(model.manifold(), {segment.x + 2, segment.x}));
  if (!rows.empty() && model.nu() > 0)
    all.emplace_back(
        "combination",
        combination_residual(
            model.ndx(),
            {{{{2, false, velocities[0], system->nv() + rows[0]}, {-3, true, 0, -1}}, 0.5}}));
  const int nv = system->nv();
  const Eigen::MatrixXd half =
      Eigen::MatrixXd::Ones(2 * nv, nv) + Eigen::MatrixXd::Identity(2 * nv, nv);
  if (model.ndx() == 2 * nv)
    all.emplace_back("weighted state",
                     weighted_residual(state_residual(model.manifold()), half * half.transpose()));
  all.emplace_back("weighted com",
                   weighted_residual(com_position_residual(system),
                                     Eigen::Matrix3d{{2, 1, 0}, {1, 3, 0}, {0, 0, 1}}));
  if (model.step().tail() > 0) all.emplace_back("rate", control_rate_residual(*system));
  for (int f = 0; f < static_cast<int>(robot.frames.size()); f += frame_step) {
    const std::string& name = robot.frames[f].name;
    all.emplace_back("position " + name, frame_position_residual(system, f));
    all.emplace_back("rotation " + name, frame_rotation_residual(system, f));
    all.emplace_back("placement " + name, frame_placement_residual(system, f));
    all.emplace_back("velocity " + name, frame_velocity_residual(system, f, FrameAxes::local));
    all.emplace_back("world velocity " + name,
                     frame_velocity_residual(system, f, FrameAxes::world_aligned));
    const FramePair pair{f, (f + 1 + f / 2) % static_cast<int>(robot.frames.size())};
    all.emplace_back("relative position " + name, frame_position_residual(system, pair));
    all.emplace_back("relative rotation " + name, frame_rotation_residual(system, pair));
    all.emplace_back("relative placement " + name, frame_placement_residual(system, pair));
    all.emplace_back("relative velocity " + name,
                     frame_velocity_residual(system, pair, FrameAxes::local));
    all.emplace_back("velocity in base " + name,
                     frame_velocity_residual(system, pair, FrameAxes::world_aligned));
  }
  return all;
}

}  // namespace conddp
