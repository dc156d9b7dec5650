#include "problem_file/terms/reach.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "problem_file/plant/posture.hpp"

namespace conddp {
namespace {

bool floats(const RobotModel& robot, int frame) {
  int joint = robot.frames[frame].joint;
  while (joint >= 0 && robot.joints[joint].type != JointType::floating)
    joint = robot.joints[joint].parent;
  return joint >= 0;
}

/// True if a free parameter may change the robot.
bool has_parameters(const RobotModel& robot) {
  return std::ranges::any_of(robot.joints,
                             [](const Joint& j) { return j.type == JointType::parameter; });
}

/// True for a frame position with equal weights on all components.
bool is_whole(const CostSpec& cost) {
  return (cost.definition->name == "frame_position" ||
          cost.definition->name == "frame_placement") &&
         cost.reference && !cost.weights && !cost.matrix;
}

void warn(const BuiltCost& cost, const Plant& plant, Diagnostics& out) {
  constexpr double kNear = 1e-4;  // m
  const std::shared_ptr<const MultibodySystem> system = plant.multibody();
  const RobotModel& robot = system->robot();
  const int frame = cost.residual.frame;
  if (!is_whole(*cost.spec) || frame < 0 || floats(robot, frame)) return;
  const std::vector<int> joints = movable_joints(*system, 0, robot.joint_count());
  std::vector<double> x =
      plant.usual_state.empty() ? system->manifold().neutral() : plant.usual_state;
  std::vector<PostureGoal> goals{{frame_position_residual(system, frame), {}}};
  for (const double time : cost.reference.times()) {
    const std::vector<double>& goal = cost.reference.hold(time);
    const std::vector<double> position(goal.begin(), goal.begin() + 3);
    if (goals.front().parameters == position) continue;
    goals.front().parameters = position;
    const Posture posture = find_posture(*system, goals, joints, x);
    x = posture.x;
    if (posture.gaps.front() < kNear) continue;
    return out.warning(
        cost.spec->reference->place,
        fmt::format("[{:.4g}, {:.4g}, {:.4g}] is out of reach of '{}': the nearest place found "
                    "within the limits of its joints is {:.3g} m away",
                    goal[0], goal[1], goal[2], robot.frames[frame].name, posture.gaps.front()),
        "places are in the world, in m");
  }
}

}  // namespace

void warn_of_reach(const std::vector<BuiltCost>& costs,
                   const std::vector<BuiltConstraint>& constraints, const Plant& plant,
                   Diagnostics& out) {
  if (plant.multibody() == nullptr) return;
  if (has_parameters(plant.robot())) return;
  for (const BuiltCost& cost : costs) warn(cost, plant, out);
  for (const BuiltConstraint& c : constraints)
    if (!c.spec->bounded && is_zero(*c.spec)) warn(c.function, plant, out);
}

}  // namespace conddp
