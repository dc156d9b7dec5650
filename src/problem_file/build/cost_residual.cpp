#include "problem_file/build/cost_residual.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "base/spelling.hpp"
#include "problem_file/data/time_series.hpp"
#include "problem_file/plant/row_names.hpp"
#include "problem_file/plant/shape_pairs.hpp"

namespace conddp {
namespace {

const std::vector<std::string> kPositionNames = {"x", "y", "z"};
const std::vector<std::string> kRotationNames = {"rx", "ry", "rz"};
const std::vector<std::string> kPoseNames = {"x", "y", "z", "rx", "ry", "rz"};
const std::vector<std::string> kMomentumNames = {"px", "py", "pz", "lx", "ly", "lz"};

/// Whether a state index is a coordinate on its own: in a flat part, or of the position of a pose.
bool is_coordinate(const StateManifold& manifold, int index) {
  using Part = StateManifold::Part;
  for (const auto& segment : manifold.segments()) {
    const int count = segment.part == Part::flat ? segment.n : segment.part == Part::se3 ? 3 : 0;
    if (index >= segment.x && index < segment.x + count) return true;
  }
  return false;
}

/// Position and velocity limits of a robot in the order of tangent vectors.
void set_state_limits(const MultibodySystem& system, CostResidual& result) {
  result.lower.assign(system.ndx(), -kUnlimited);
  result.upper.assign(system.ndx(), kUnlimited);
  for (int joint = 0; joint < system.robot().joint_count(); ++joint) {
    if (!is_independent(system.robot(), joint)) continue;
    const MultibodySystem::JointLimits limits = system.limits(joint);
    const int row = *system.velocity_row(joint);
    result.lower[row] = limits.lower;
    result.upper[row] = limits.upper;
    result.lower[system.nv() + row] = -limits.max_velocity;
    result.upper[system.nv() + row] = limits.max_velocity;
  }
}

/// Whether a constant, as a running cost, costs time.
bool time_counts(const ProblemSpec& spec) {
  return std::any_of(spec.phases.begin(), spec.phases.end(),
                     [](const PhaseSpec& phase) { return phase.free_duration.has_value(); });
}

/// The columns of the rows by name: of the state where that has one, else of the control.
std::optional<std::vector<LinearCombination>> find_combinations(const CostSpec& cost,
                                                                const ProblemSpec& spec,
                                                                const System& system,
                                                                Diagnostics& out) {
  std::vector<std::string> known{"constant"};
  std::vector<LinearCombination::Term> terms{{}};
  for (const auto& segment : system.manifold().segments())
    for (int i = 0; segment.part == StateManifold::Part::flat && i < segment.n; ++i) {
      known.push_back(system.state_columns()[segment.x + i].name);
      terms.push_back({0, false, segment.x + i, segment.dx + i});
    }
  for (int i = 0; i < system.nu(); ++i) {
    const std::string& name = system.control_columns()[i].name;
    const bool taken = std::find(known.begin(), known.end(), name) != known.end();
    known.push_back((taken ? "u/" : "") + name);
    terms.push_back({0, true, i, -1});
  }
  std::vector<LinearCombination> rows;
  bool good = true;
  for (const NamedNumbers& given : cost.combinations) {
    LinearCombination& row = rows.emplace_back();
    for (const auto& [name, factor] : given) {
      const auto found = std::find(known.begin(), known.end(), name.value);
      if (found == known.end()) {
        out.error(name.place,
                  fmt::format("'{}' is not a column of the state or control that can be combined",
                              name.value),
                  name_hint(name.value, known, "columns"), known);
        good = false;
      } else if (found == known.begin()) {
        row.constant = factor;
      } else {
        row.terms.push_back(terms[found - known.begin()]);
        row.terms.back().factor = factor;
      }
    }
    const bool costs_time = row.constant != 0 && time_counts(spec);
    if (!row.terms.empty() || costs_time || !good) continue;
    out.error(cost.residual.place, "a row combines nothing", "give the factor of a column");
    good = false;
  }
  if (!good) return std::nullopt;
  return rows;
}

/// By number of the state; rotations have no sum.
std::optional<std::vector<double>> cycle_offset(const CostSpec& cost, const Plant& plant,
                                                Diagnostics& out) {
  const System& system = *plant.system;
  if (!cost.offset) return std::vector<double>(system.nx(), 0.0);
  auto offset = resolve(*cost.offset, state_names(system), 0.0, out);
  if (!offset) return std::nullopt;
  for (const auto& segment : system.manifold().curved()) {
    const int first = segment.x + (segment.part == StateManifold::Part::se3 ? 3 : 0);
    for (int i = first; i < first + 4; ++i) {
      if ((*offset)[i] == 0) continue;
      out.error(cost.offset->place, "an offset cannot be added to a rotation",
                "positions, joints and velocities can have one");
      return std::nullopt;
    }
  }
  return offset;
}

/// Of the columns that can be chosen those that a name means, several where it has a `*`; none is
/// reported.
std::vector<std::string> find_columns(const std::vector<std::string>& all,
                                      const std::vector<std::string>& free, const Name& name,
                                      Diagnostics& out) {
  std::vector<std::string> found;
  std::copy_if(free.begin(), free.end(), std::back_inserter(found),
               [&](const std::string& column) { return fits(name.value, column); });
  if (!found.empty()) return found;
  const bool rotation = std::any_of(
      all.begin(), all.end(), [&](const std::string& column) { return fits(name.value, column); });
  out.error(name.place,
            rotation
                ? fmt::format("'{}' is part of a rotation and cannot be chosen alone", name.value)
                : fmt::format("the state has no column '{}'", name.value),
            name_hint(name.value, free, "columns that can be chosen"));
  return found;
}

bool choose_columns(const CostSpec& cost, const System& system, CostResidual& result,
                    Diagnostics& out) {
  const ComponentNames all = state_names(system);
  std::vector<std::string> free, chosen;
  for (int i = 0; i < system.nx(); ++i)
    if (is_coordinate(system.manifold(), i)) free.push_back(all.names[i]);
  for (const Name& name : *cost.columns) {
    const auto found = find_columns(all.names, free, name, out);
    if (found.empty()) return false;
    for (const std::string& column : found) {
      if (std::find(chosen.begin(), chosen.end(), column) != chosen.end()) continue;
      chosen.push_back(column);
      const auto at = std::find(all.names.begin(), all.names.end(), column);
      result.indices.push_back(static_cast<int>(at - all.names.begin()));
    }
  }
  result.rows = result.references = {"chosen columns", chosen};
  return true;
}

/// Joints of a residual: those named, else all. Writes names and limits.
std::optional<std::vector<int>> choose_joints(const CostSpec& cost, const RobotModel& robot,
                                              CostResidual& result, Diagnostics& out) {
  std::vector<int> joints;
  bool known = true;
  if (cost.joints) {
    for (const Name& name : *cost.joints) {
      const std::vector<int> found = find_joints(robot, name, "", out);
      known &= !found.empty();
      for (const int joint : found)
        if (std::find(joints.begin(), joints.end(), joint) == joints.end()) joints.push_back(joint);
    }
  } else {
    for (int i = 0; i < robot.joint_count(); ++i)
      if (is_independent(robot, i)) joints.push_back(i);
  }
  if (!known) return std::nullopt;
  if (joints.empty()) {
    out.error(cost.residual.place, fmt::format("the cost '{}' has no joint", cost.name.value));
    return std::nullopt;
  }
  std::vector<std::string> names;
  for (const int joint : joints) names.push_back(robot.joints[joint].name);
  result.rows = result.references = {"joints", names};
  result.parameters = StateManifold::flat(static_cast<int>(joints.size()));
  return joints;
}

void make_joint_residual(const CostSpec& cost, const Plant& plant, int ndx, CostResidual& result,
                         Diagnostics& out) {
  const MultibodySystem& system = *plant.multibody();
  const auto joints = choose_joints(cost, system.robot(), result, out);
  if (!joints) return;
  const bool position = cost.kind == ResidualKind::kJointPosition;
  for (const int joint : *joints) {
    if (cost.kind == ResidualKind::kJointAcceleration) {
      result.indices.push_back(*system.velocity_row(joint));
      continue;
    }
    const MultibodySystem::JointLimits limits = system.limits(joint);
    result.indices.push_back(position ? *system.position_index(joint)
                                      : *system.velocity_index(joint));
    result.lower.push_back(position ? limits.lower : -limits.max_velocity);
    result.upper.push_back(position ? limits.upper : limits.max_velocity);
  }
  result.residual = cost.kind == ResidualKind::kJointAcceleration
                        ? acceleration_residual(*plant.system, ndx, result.indices)
                        : coordinate_residual(system.manifold(), result.indices);
}

void make_frame_residual(const CostSpec& cost, const Plant& plant, CostResidual& result,
                         Diagnostics& out) {
  const auto frame = find_frame(plant.robot(), *cost.frame, "", out);
  if (!frame) return;
  result.frame = *frame;
  if (cost.kind == ResidualKind::kFramePosition) {
    result.residual = frame_position_residual(plant.multibody(), *frame);
    result.rows = {"axes of the position", kPositionNames};
    result.parameters = StateManifold::flat(3);
  } else if (cost.kind == ResidualKind::kFrameRotation) {
    result.residual = frame_rotation_residual(plant.multibody(), *frame);
    result.rows = {"axes of the rotation", kRotationNames};
    result.parameters = rotation_manifold();
  } else if (cost.kind == ResidualKind::kFramePlacement) {
    result.residual = frame_placement_residual(plant.multibody(), *frame);
    result.rows = {"axes of the placement", kPoseNames};
    result.parameters = pose_manifold();
  } else {
    result.residual = frame_velocity_residual(plant.multibody(), *frame, cost.axes);
    result.rows = {"axes of the velocity", kTwistNames};
    result.parameters = StateManifold::flat(6);
  }
}

void make_distance_residual(const CostSpec& cost, const ProblemSpec& spec, const Plant& plant,
                            CostResidual& result, Diagnostics& out) {
  std::vector<DistancePair> shapes;
  std::vector<std::string> names;
  for (const ShapePair& pair : shape_pairs(cost, spec, plant, out)) {
    shapes.push_back(pair.shapes);
    const std::string name = pair.first + "-" + pair.second;
    if (pair.shapes.rows() == 1) {
      names.push_back(name);
      continue;
    }
    names.push_back(name + "/from");
    names.push_back(name + "/to");
  }
  if (shapes.empty()) return;
  result.residual = distance_residual(plant.multibody(), shapes);
  result.rows = {"distances", names};
}

}  // namespace

std::optional<CostResidual> make_cost_residual(const CostSpec& cost, const ProblemSpec& spec,
                                               const Plant& plant, int ndx, Diagnostics& out) {
  const System& system = *plant.system;
  const ResidualInfo& info = residual_info(cost.kind);
  if (info.needs_robot && !plant.multibody()) {
    out.error(
        cost.residual.place,
        fmt::format("the residual '{}' needs a robot; this is a closed-form system", info.name),
        "use 'state' (with 'columns') and 'control'");
    return std::nullopt;
  }
  CostResidual result;
  switch (cost.kind) {
    case ResidualKind::kState:
      if (cost.columns) {
        if (!choose_columns(cost, system, result, out)) break;
        result.residual = coordinate_residual(system.manifold(), result.indices);
        result.parameters = StateManifold::flat(static_cast<int>(result.indices.size()));
      } else {
        result.residual = state_residual(system.manifold());
        result.rows = tangent_names(system);
        result.references = state_names(system);
        result.parameters = system.manifold();
        if (plant.multibody()) set_state_limits(*plant.multibody(), result);
      }
      break;
    case ResidualKind::kControl:
      result.residual = control_residual(ndx, plant.actuated().nu());
      result.rows = result.references = control_names(plant.actuated());
      result.parameters = StateManifold::flat(plant.actuated().nu());
      result.lower = plant.actuated().control_lower();
      result.upper = plant.actuated().control_upper();
      break;
    case ResidualKind::kCombination: {
      std::vector<std::string> rows;
      for (std::size_t i = 0; i < cost.combinations.size(); ++i)
        rows.push_back(std::to_string(i + 1));
      if (auto combinations = find_combinations(cost, spec, system, out))
        result.residual = combination_residual(ndx, std::move(*combinations));
      result.rows = {"rows", std::move(rows)};
      break;
    }
    case ResidualKind::kCycle:
      if (const auto offset = cycle_offset(cost, plant, out))
        result.residual = cycle_residual(system.manifold(), *plant.start, *offset);
      result.rows = tangent_names(system);
      break;
    case ResidualKind::kControlRate:
      result.residual = control_rate_residual(plant.actuated());
      result.rows = control_names(plant.actuated());
      break;
    case ResidualKind::kJointPosition:
    case ResidualKind::kJointVelocity:
    case ResidualKind::kJointAcceleration:
      make_joint_residual(cost, plant, ndx, result, out);
      break;
    case ResidualKind::kFramePosition:
    case ResidualKind::kFrameRotation:
    case ResidualKind::kFramePlacement:
    case ResidualKind::kFrameVelocity:
      make_frame_residual(cost, plant, result, out);
      break;
    case ResidualKind::kComPosition:
      result.residual = com_position_residual(plant.multibody());
      result.rows = {"axes of the position", kPositionNames};
      result.parameters = StateManifold::flat(3);
      break;
    case ResidualKind::kControlGravity: {
      result.residual = control_gravity_residual(plant.multibody(), ndx);
      const std::vector<std::string> tangent = tangent_names(system).names;
      std::vector<std::string> names;
      for (const int row : plant.multibody()->actuated_rows()) names.push_back(tangent[row]);
      result.rows = {"actuated forces", names};
      break;
    }
    case ResidualKind::kCentroidalMomentum:
      result.residual = centroidal_momentum_residual(plant.multibody());
      result.rows = result.references = {"components of the momentum", kMomentumNames};
      result.parameters = StateManifold::flat(6);
      break;
    case ResidualKind::kDistance:
      make_distance_residual(cost, spec, plant, result, out);
      break;
    case ResidualKind::kContactForce:
    case ResidualKind::kFrictionCone:
    case ResidualKind::kWrenchCone:
    case ResidualKind::kCenterOfPressure:
    case ResidualKind::kContactVelocity:
      break;  // make_contact_costs
  }
  if (!result.residual) return std::nullopt;
  return result;
}

}  // namespace conddp
