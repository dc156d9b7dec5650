#include "systems/contact/stepping_layout.hpp"

#include <cmath>

#include <fmt/format.h>

namespace conddp {
namespace {

int add(std::vector<Column>& columns, std::string name, std::string unit) {
  columns.push_back({std::move(name), std::move(unit)});
  return static_cast<int>(columns.size()) - 1;
}

/// The names of forces and slips along the tangents: t+, t- in a plane, t1+ … t2- in space.
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

/// Of two tangents: forces first, then what they follow from.
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

}  // namespace

SteppingLayout::SteppingLayout(const RobotModel& robot, const std::vector<Column>& actuator_columns,
                               const ImplicitContacts& contacts)
    : actuators(static_cast<int>(actuator_columns.size())),
      acceleration(actuators),
      nv(robot.nv),
      columns(actuator_columns) {
  const auto turns = [&](int joint) { return robot.joints[joint].type == JointType::revolute; };
  for (int j = 0; j < robot.joint_count(); ++j) {
    const std::string name = "a/" + robot.joints[j].name;
    if (robot.joints[j].type != JointType::floating) {
      add(columns, name, turns(j) ? "rad/s²" : "m/s²");
      continue;
    }
    for (const char* axis : {"x", "y", "z"}) add(columns, name + "/v" + axis, "m/s²");
    for (const char* axis : {"x", "y", "z"}) add(columns, name + "/w" + axis, "rad/s²");
  }
  for (const ContactCandidate& c : contacts.candidates) {
    const std::string prefix = "contact/" + c.name;
    Candidate indices;
    indices.force = add(columns, prefix + "/fn", "N");
    indices.gap = add(columns, prefix + "/gap", "m");
    pairs.emplace_back(indices.force, indices.gap);
    // Along one tangent the cone is the pyramid.
    if (c.friction > 0 && contacts.friction == FrictionModel::cone && !contacts.plane)
      indices.cone = add_cone(*this, prefix);
    else if (c.friction > 0)
      indices.friction = add_friction(*this, prefix, contacts.plane ? 1 : 2, "N", "m/s");
    candidates.push_back(indices);
  }
  for (const JointStop& stop : contacts.stops)
    for (const bool upper : {false, true}) {
      const double limit = upper ? stop.upper : stop.lower;
      if (!std::isfinite(limit)) continue;
      const std::string prefix =
          "stop/" + robot.joints[stop.joint].name + (upper ? "/upper" : "/lower");
      Stop indices{.joint = stop.joint,
                   .position = robot.joints[stop.joint].q,
                   .velocity = robot.joints[stop.joint].v,
                   .upper = upper,
                   .limit = limit};
      indices.force = add(columns, prefix + "/f", turns(stop.joint) ? "Nm" : "N");
      indices.distance = add(columns, prefix + "/distance", turns(stop.joint) ? "rad" : "m");
      pairs.emplace_back(indices.force, indices.distance);
      stops.push_back(indices);
    }
  for (const JointFriction& friction : contacts.frictions) {
    friction_velocities.push_back(robot.joints[friction.joint].v);
    frictions.push_back(add_friction(*this, "friction/" + robot.joints[friction.joint].name, 1,
                                     turns(friction.joint) ? "Nm" : "N",
                                     turns(friction.joint) ? "rad/s" : "m/s"));
  }
}

}  // namespace conddp
