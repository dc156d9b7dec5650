#include "problem_file/terms/reach.hpp"

#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "systems/multibody/multibody.hpp"

namespace conddp {
namespace {

/// A ball that contains all positions of a frame.
struct Reach {
  Vector3<double> center;
  double radius = 0;
};

std::optional<Reach> reach_of(const RobotModel& robot, int frame) {
  Vector3<double> arm = robot.frames[frame].placement.p;
  double radius = 0;
  for (int j = robot.frames[frame].joint; j >= 0; j = robot.joints[j].parent) {
    if (robot.joints[j].type != JointType::revolute) return std::nullopt;
    radius += std::sqrt(squared_norm(arm));
    arm = robot.joints[j].placement.p;
  }
  return Reach{arm, radius};
}

/// True for a frame position with equal weights on all components.
bool is_whole(const CostSpec& cost) {
  return (cost.definition->name == "frame_position" ||
          cost.definition->name == "frame_placement") &&
         cost.reference && !cost.weights && !cost.matrix;
}

void warn(const BuiltCost& cost, const RobotModel& robot, Diagnostics& out) {
  constexpr double kRounding = 1e-6;
  if (!is_whole(*cost.spec) || cost.residual.frame < 0) return;
  const auto reach = reach_of(robot, cost.residual.frame);
  if (!reach) return;
  for (const double time : cost.reference.times()) {
    const std::vector<double>& goal = cost.reference.hold(time);
    const double far =
        std::sqrt(squared_norm(Vector3<double>{goal[0], goal[1], goal[2]} - reach->center));
    if (far <= reach->radius + kRounding) continue;
    return out.warning(
        cost.spec->reference->place,
        fmt::format("[{:.4g}, {:.4g}, {:.4g}] is out of reach of '{}': {:.4g} m from its first "
                    "joint, behind which the links are {:.4g} m long together",
                    goal[0], goal[1], goal[2], robot.frames[cost.residual.frame].name, far,
                    reach->radius),
        "places are in the world, in m");
  }
}

}  // namespace

void warn_of_reach(const std::vector<BuiltCost>& costs,
                   const std::vector<BuiltConstraint>& constraints, const Plant& plant,
                   Diagnostics& out) {
  if (plant.multibody() == nullptr) return;
  const RobotModel& robot = plant.multibody()->robot();
  for (const BuiltCost& cost : costs) warn(cost, robot, out);
  for (const BuiltConstraint& c : constraints)
    if (!c.spec->bounded && is_zero(*c.spec)) warn(c.function, robot, out);
}

}  // namespace conddp
