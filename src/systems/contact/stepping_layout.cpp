#include "systems/contact/stepping_layout.hpp"

#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

int add(std::vector<Column>& columns, std::string name, std::string unit) {
  columns.push_back({std::move(name), std::move(unit)});
  return static_cast<int>(columns.size()) - 1;
}

/// Adds forces and slips along the tangents, named t+, t- in a plane, t1+ … t2- in space.
FrictionIndices add_friction(SteppingLayout& layout, const std::string& prefix, int tangents,
                             const std::string& force_unit, const std::string& slip_unit) {
  FrictionIndices f{.count = 2 * tangents};
  for (int i = 0; i < f.count; ++i) {
    const std::string label =
        (tangents == 1 ? "t" : "t" + std::to_string(1 + i / 2)) + (i % 2 == 0 ? "+" : "-");
    f.force[i] = add(layout.columns, prefix + "/f" + label, force_unit);
    f.slip[i] = add(layout.columns, prefix + "/slip_" + label, slip_unit);
    layout.pairs.emplace_back(f.force[i], f.slip[i]);
  }
  f.gamma = add(layout.columns, prefix + "/slip_speed", slip_unit);
  f.rest = add(layout.columns, prefix + "/friction_left", force_unit);
  layout.pairs.emplace_back(f.gamma, f.rest);
  return f;
}

/// Adds the unknowns of two tangents: first the forces, then the variables that determine them.
ConeIndices add_cone(SteppingLayout& layout, const std::string& prefix) {
  ConeIndices cone{.present = true};
  for (int i = 0; i < 2; ++i)
    cone.force[i] = add(layout.columns, fmt::format("{}/ft{}", prefix, i + 1), "N");
  for (int i = 0; i < 2; ++i)
    cone.use[i] = add(layout.columns, fmt::format("{}/use{}", prefix, i + 1), "");
  cone.speed = add(layout.columns, prefix + "/slip_speed", "m/s");
  cone.rest = add(layout.columns, prefix + "/use_left", "");
  layout.pairs.emplace_back(cone.speed, cone.rest);
  return cone;
}

bool turns(const Joint& joint) { return joint.type == JointType::revolute; }

void add_acceleration(SteppingLayout& layout, const Joint& joint) {
  const std::string name = "a/" + joint.name;
  if (joint.type != JointType::floating) {
    add(layout.columns, name, turns(joint) ? "rad/s²" : "m/s²");
    return;
  }
  for (const char* axis : {"x", "y", "z"}) add(layout.columns, name + "/v" + axis, "m/s²");
  for (const char* axis : {"x", "y", "z"}) add(layout.columns, name + "/w" + axis, "rad/s²");
}

void add_candidate(SteppingLayout& layout, const ContactCandidate& c,
                   const ImplicitContacts& contacts) {
  const std::string prefix = "contact/" + c.name;
  SteppingLayout::Candidate indices;
  indices.force = add(layout.columns, prefix + "/fn", "N");
  indices.gap = add(layout.columns, prefix + "/gap", "m");
  layout.pairs.emplace_back(indices.force, indices.gap);
  // With one tangent, the cone is the pyramid.
  if (c.friction > 0 && contacts.friction == FrictionModel::cone && !contacts.plane)
    indices.cone = add_cone(layout, prefix);
  else if (c.friction > 0)
    indices.friction = add_friction(layout, prefix, contacts.plane ? 1 : 2, "N", "m/s");
  layout.candidates.push_back(indices);
}

/// Adds the lower or upper end of a joint's range, if it is finite.
void add_stop(SteppingLayout& layout, const Joint& joint, const JointStop& stop, bool upper) {
  const double limit = upper ? stop.upper : stop.lower;
  if (!std::isfinite(limit)) return;
  const std::string prefix = "stop/" + joint.name + (upper ? "/upper" : "/lower");
  SteppingLayout::Stop indices{.joint = stop.joint,
                               .position = joint.q,
                               .velocity = joint.v,
                               .upper = upper,
                               .limit = limit};
  indices.force = add(layout.columns, prefix + "/f", turns(joint) ? "Nm" : "N");
  indices.distance = add(layout.columns, prefix + "/distance", turns(joint) ? "rad" : "m");
  layout.pairs.emplace_back(indices.force, indices.distance);
  layout.stops.push_back(indices);
}

void add_joint_friction(SteppingLayout& layout, const Joint& joint) {
  layout.friction_velocities.push_back(joint.v);
  const bool turning = turns(joint);
  layout.frictions.push_back(add_friction(layout, "friction/" + joint.name, 1, turning ? "Nm" : "N",
                                          turning ? "rad/s" : "m/s"));
}

}  // namespace

SteppingLayout::SteppingLayout(const RobotModel& robot, const std::vector<Column>& actuator_columns,
                               const ImplicitContacts& contacts)
    : actuators(static_cast<int>(actuator_columns.size())),
      acceleration(actuators),
      nv(robot.nv),
      columns(actuator_columns) {
  for (const Joint& joint : robot.joints) add_acceleration(*this, joint);
  for (const ContactCandidate& c : contacts.candidates) add_candidate(*this, c, contacts);
  for (const JointStop& stop : contacts.stops)
    for (const bool upper : {false, true}) add_stop(*this, robot.joints[stop.joint], stop, upper);
  for (const JointFriction& friction : contacts.frictions)
    add_joint_friction(*this, robot.joints[friction.joint]);
}

}  // namespace conddp
