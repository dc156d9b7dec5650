#include <algorithm>

#include <fmt/format.h>

#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

const Key<std::vector<Name>> kJoints{"joints"};

std::vector<int> all_joints(const RobotModel& robot) {
  std::vector<int> joints;
  for (int i = 0; i < robot.joint_count(); ++i)
    if (is_independent(robot, i)) joints.push_back(i);
  return joints;
}

/// The joints that fit the names, each once; empty if a name is unknown.
std::optional<std::vector<int>> joints_named(const std::vector<Name>& names,
                                             const RobotModel& robot, Diagnostics& out) {
  std::vector<int> joints;
  bool known = true;
  for (const Name& name : names) {
    const std::vector<int> found = find_joints(robot, name, "", out);
    known &= !found.empty();
    for (const int joint : found)
      if (std::find(joints.begin(), joints.end(), joint) == joints.end()) joints.push_back(joint);
  }
  if (!known) return std::nullopt;
  return joints;
}

/// Joints of a residual: the named joints, otherwise all.
std::optional<std::vector<int>> choose_joints(const CostSpec& cost, const RobotModel& robot,
                                              Diagnostics& out) {
  const std::vector<Name>* names = cost.keys.find(kJoints);
  auto joints = names != nullptr ? joints_named(*names, robot, out) : all_joints(robot);
  if (!joints || !joints->empty()) return joints;
  out.error(cost.residual.place, fmt::format("the cost '{}' has no joint", cost.name.value));
  return std::nullopt;
}

CostResidual named_by(const std::vector<int>& joints, const RobotModel& robot) {
  std::vector<std::string> names;
  for (const int joint : joints) names.push_back(robot.joints[joint].name);
  CostResidual result;
  result.rows = result.references = {"joints", names};
  result.parameters = StateManifold::flat(static_cast<int>(joints.size()));
  return result;
}

/// Sets a residual on numbers of the state.
void set_coordinates(const System& system, CostResidual& result) {
  const std::vector<std::string> names = state_names(system).names;
  for (const int i : result.indices) result.columns.push_back(names[i]);
  result.residual = coordinate_residual(system.manifold(), result.indices);
  result.in_state = [indices = result.indices](const std::vector<double>& x) {
    std::vector<double> values;
    for (const int i : indices) values.push_back(x[i]);
    return values;
  };
}

/// A coordinate of the state, and its limits in the URDF.
struct JointCoordinate {
  int index;
  double lower, upper;
};

/// A residual on one coordinate of each joint.
std::optional<CostResidual> make_coordinates(
    const ResidualContext& context,
    JointCoordinate (*coordinate)(const MultibodySystem& system, int joint)) {
  const MultibodySystem& system = *context.plant.multibody();
  const auto joints = choose_joints(context.cost, system.robot(), context.out);
  if (!joints) return std::nullopt;
  CostResidual result = named_by(*joints, system.robot());
  for (const int joint : *joints) {
    const auto [index, lower, upper] = coordinate(system, joint);
    result.indices.push_back(index);
    result.lower.push_back(lower);
    result.upper.push_back(upper);
  }
  set_coordinates(*context.plant.system, result);
  return result;
}

std::optional<CostResidual> make_position(const ResidualContext& context) {
  return make_coordinates(context, [](const MultibodySystem& system, int joint) {
    const MultibodySystem::JointLimits limits = system.limits(joint);
    return JointCoordinate{*system.position_index(joint), limits.lower, limits.upper};
  });
}

std::optional<CostResidual> make_velocity(const ResidualContext& context) {
  return make_coordinates(context, [](const MultibodySystem& system, int joint) {
    const double most = system.limits(joint).max_velocity;
    return JointCoordinate{*system.velocity_index(joint), -most, most};
  });
}

std::optional<CostResidual> make_acceleration(const ResidualContext& context) {
  const MultibodySystem& system = *context.plant.multibody();
  const auto joints = choose_joints(context.cost, system.robot(), context.out);
  if (!joints) return std::nullopt;
  CostResidual result = named_by(*joints, system.robot());
  for (const int joint : *joints) result.indices.push_back(*system.velocity_row(joint));
  // Collocation slopes are not controls at the beginning of a knot with linear controls.
  const System& system_there =
      context.spec.has_linear_controls() ? context.plant.actuated() : *context.plant.system;
  result.residual = acceleration_residual(system_there, context.ndx, result.indices);
  // A state contains no accelerations; the reference is zero.
  result.in_state = [n = joints->size()](const std::vector<double>&) {
    return std::vector<double>(n, 0.0);
  };
  return result;
}

}  // namespace

std::span<const ResidualDefinition> joint_residuals() {
  static const ResidualKey joints = [] {
    ResidualKey key = residual_key(
        kJoints, {.says = "For residuals on joints; names may have a *; all by default"},
        NameOrNamesForm{});
    key.complete = [](CostSpec& cost, const TermContext& context) {
      std::vector<Name> all;
      for (const std::string& name : joint_names(context.plant.robot())) all.push_back({name, {}});
      if (cost.keys.find(kJoints) == nullptr) cost.keys.set(kJoints, std::move(all));
    };
    return key;
  }();
  static const ResidualDefinition all[] = {{.name = "joint_position",
                                            .description = "joint positions minus a reference",
                                            .unit = "rad or m",
                                            .synonyms = {"configuration", "joint", "posture", "q"},
                                            .needs = {.robot = true},
                                            .keys = {&joints},
                                            .reference = &kNumbersReference,
                                            .has_limits = true,
                                            .is_point = [](const CostSpec&) { return true; },
                                            .of_positions = true,
                                            .make = make_position},
                                           {.name = "joint_velocity",
                                            .description = "joint velocities minus a reference",
                                            .unit = "rad/s or m/s",
                                            .synonyms = {"velocity", "v"},
                                            .needs = {.robot = true},
                                            .keys = {&joints},
                                            .reference = &kNumbersReference,
                                            .has_limits = true,
                                            .make = make_velocity},
                                           {.name = "joint_acceleration",
                                            .description = "joint accelerations minus a reference",
                                            .unit = "rad/s² or m/s²",
                                            .synonyms = {"acceleration", "a"},
                                            .needs = {.robot = true, .control = true},
                                            .keys = {&joints},
                                            .reference = &kNumbersReference,
                                            .make = make_acceleration}};
  return all;
}

}  // namespace conddp
