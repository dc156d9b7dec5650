#include "problem_file/plant.hpp"

#include <algorithm>
#include <stdexcept>

#include <fmt/format.h>

#include "problem_file/collocation_builder.hpp"
#include "problem_file/components.hpp"
#include "problem_file/plant_robot.hpp"
#include "problem_file/stepping_builder.hpp"
#include "robot/combine.hpp"
#include "robot/frames.hpp"
#include "robot/kinematics.hpp"
#include "robot/near_names.hpp"

namespace conddp {
namespace {

template <class... Cases>
struct Overloaded : Cases... {
  using Cases::operator()...;
};
template <class... Cases>
Overloaded(Cases...) -> Overloaded<Cases...>;  // some compilers do not deduce it themselves

/// The step of a discrete system: all phases must have it.
std::optional<double> common_step(const ProblemSpec& spec, Diagnostics& out) {
  const PhaseSpec& first = spec.phases[spec.phases.front().choice && spec.phases.size() > 1];
  const double dt = first.dt;
  for (const PhaseSpec& phase : spec.phases)
    if (phase.choice) {
      continue;
    } else if (phase.refine) {
      out.error(phase.name.place, "the steps of this system must have the same length",
                fmt::format("leave 'refine' out of '{}'", phase.name.value));
      return std::nullopt;
    } else if (phase.dt != dt) {
      out.error(phase.name.place, "the phases of this system must have the same dt",
                fmt::format("'{}' has {}, '{}' has {}", first.name.value, dt, phase.name.value,
                            phase.dt));
      return std::nullopt;
    }
  return dt;
}

std::shared_ptr<const System> make_system(const ProblemSpec& spec, Diagnostics& out) {
  using Result = std::shared_ptr<const System>;
  return std::visit(
      Overloaded{
          [](const DoubleIntegratorSpec& p) -> Result { return double_integrator(p.dimension); },
          [](const LinearSpec& p) -> Result { return linear_system(p.A, p.B, p.c); },
          [](const PendulumParameters& p) -> Result { return pendulum(p); },
          [](const CartpoleParameters& p) -> Result { return cartpole(p); },
          [](const AcrobotParameters& p) -> Result { return acrobot(p); },
          [](const UnicycleSpec&) -> Result { return unicycle(); },
          [&](const CarSpec& p) -> Result {
            const auto step = common_step(spec, out);
            return step ? car(p.wheelbase, *step) : nullptr;
          },
          [](const PlanarQuadrotorParameters& p) -> Result { return planar_quadrotor(p); },
          [](const QuadrotorParameters& p) -> Result { return quadrotor(p); },
          [](const LanderParameters& p) -> Result { return lander(p); },
      },
      spec.system->parameters);
}

/// Where a joint and those that mimic it can all be within their limits: else both are named.
bool check_mimic_limits(const Plant& plant, Diagnostics& out) {
  const RobotModel& robot = plant.robot();
  bool possible = true;
  for (const Mimic& mimic : robot.mimics) {
    const Joint& leader = robot.joints[mimic.leader];
    const Joint& follower = robot.joints[mimic.joint];
    const auto limits = plant.multibody->limits(mimic.leader);
    if (limits.lower <= limits.upper) continue;
    out.error(part_of(plant, mimic.leader).spec->place,
              fmt::format("no position of the joint '{}' (limits {} to {}) keeps the limits {} to "
                          "{} of the joint '{}', which mimics it with multiplier {} and offset {}",
                          leader.name, leader.lower, leader.upper, follower.lower, follower.upper,
                          follower.name, mimic.multiplier, mimic.offset),
              "correct the limits in the URDF, or write 'mimic: ignore'");
    possible = false;
  }
  return possible;
}

}  // namespace

std::optional<Plant> build_plant(const ProblemSpec& spec, Diagnostics& out) {
  Plant plant;
  if (spec.system) {
    plant.system = make_system(spec, out);
    if (!plant.system || !collocate(spec, plant, out)) return std::nullopt;
    return plant;
  }
  std::vector<RobotModel> trees;
  int joints = 0;
  for (const RobotSpec& robot : spec.robots) {
    const std::string prefix = robot.name.value.empty() ? "" : robot.name.value + "/";
    std::string hash;
    auto tree = load_robot(robot, prefix, spec.gravity, hash, out);
    if (!tree) continue;
    plant.parts.push_back({&robot, prefix, joints, tree->joint_count(), std::move(hash)});
    joints += tree->joint_count();
    trees.push_back(std::move(*tree));
  }
  if (trees.size() != spec.robots.size()) return std::nullopt;
  auto model = std::make_shared<RobotModel>(combine(std::move(trees)));
  add_external_wrenches(plant.parts, *model, out);
  const auto actuation = make_actuation(plant.parts, *model, out);
  const auto passive = make_passive_forces(plant.parts, *model, out);
  if (!actuation || !passive) return std::nullopt;
  try {
    plant.multibody = std::make_shared<MultibodySystem>(model, *actuation, *passive);
  } catch (const std::invalid_argument& e) {  // chains of mimic joints that cannot be resolved
    out.error(plant.parts.front().spec->place, e.what());
    return std::nullopt;
  }
  plant.system = plant.multibody;
  if (!check_mimic_limits(plant, out)) return std::nullopt;
  if (!spec.stepping) {
    if (!collocate(spec, plant, out)) return std::nullopt;
    return plant;
  }
  plant.stepping = build_stepping(spec, plant, out);
  if (!plant.stepping) return std::nullopt;
  plant.system = plant.stepping;
  return plant;
}

const PlantPart& part_of(const Plant& plant, int joint) {
  return *std::find_if(plant.parts.begin(), plant.parts.end(), [&](const PlantPart& p) {
    return joint >= p.first_joint && joint < p.first_joint + p.joint_count;
  });
}

bool is_independent(const RobotModel& robot, int joint) {
  if (robot.joints[joint].type == JointType::floating) return false;
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

std::optional<int> find_frame(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out) {
  const auto frame = robot.find_frame(prefix + name.value);
  if (!frame)
    out.error(name.place, fmt::format("the robot has no frame '{}'", prefix + name.value),
              name_hint(prefix + name.value, frame_names(robot), "frames"));
  return frame;
}

std::optional<int> find_joint(const RobotModel& robot, const Name& name, const std::string& prefix,
                              Diagnostics& out) {
  const std::string full = prefix + name.value;
  const auto joint = robot.find_joint(full);
  if (joint && is_independent(robot, *joint)) return joint;
  if (joint && robot.joints[*joint].type == JointType::floating)
    out.error(name.place, fmt::format("'{}' is the floating base, not a joint", full));
  else if (joint)
    out.error(name.place, fmt::format("the joint '{}' follows another one", full),
              "name the joint that it mimics, or write 'mimic: ignore'");
  else if (const auto frame = robot.find_frame(full);
           frame && robot.frames[*frame].kind == FrameKind::joint)
    out.error(name.place, fmt::format("the joint '{}' does not move: it is fixed or locked", full),
              name_hint(full, joint_names(robot), "joints"));
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
