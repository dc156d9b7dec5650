#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

/// kg m²; the six entries as URDF names them, those off the diagonal zero by default.
std::optional<Symmetric3<double>> read_inertia(const YamlReader& reader) {
  YamlMap map(reader);
  if (!map.valid()) return std::nullopt;
  double xx = 0, yy = 0, zz = 0, xy = 0, xz = 0, yz = 0;
  for (const auto& [key, value] : {std::pair{"ixx", &xx}, {"iyy", &yy}, {"izz", &zz}})
    if (const auto r = map.require(key)) *value = r->number(kNotNegative).value_or(0);
  map.number("ixy", xy);
  map.number("ixz", xz);
  map.number("iyz", yz);
  return Symmetric3<double>{xx, xy, xz, yy, yz, zz};
}

PayloadSpec read_payload(const Name& link, const YamlReader& reader) {
  PayloadSpec payload{.link = link};
  YamlMap map(reader);
  if (const auto r = map.require("mass")) payload.mass = r->number(kPositive).value_or(0);
  if (const auto r = map.find("com"))
    payload.com = read_vector3(*r, "[x, y, z] in m").value_or(payload.com);
  if (const auto r = map.find("inertia")) payload.inertia = read_inertia(*r);
  return payload;
}

WrenchSpec read_wrench(const YamlReader& reader) {
  WrenchSpec spec;
  YamlMap map(reader);
  if (const auto r = map.require("frame")) spec.frame = r->name().value_or(Name{});
  if (const auto r = map.find("force"))
    spec.wrench.linear = read_vector3(*r, "[x, y, z] in N").value_or(spec.wrench.linear);
  if (const auto r = map.find("torque"))
    spec.wrench.angular = read_vector3(*r, "[x, y, z] in Nm").value_or(spec.wrench.angular);
  return spec;
}

PassiveSpec read_passive(const YamlReader& reader) {
  PassiveSpec passive;
  YamlMap map(reader);
  if (const auto r = map.find("damping"))
    passive.damping = r->choice(kPassiveWords, "source of damping").value_or(false);
  if (const auto r = map.find("friction"))
    passive.friction = r->choice(kPassiveWords, "source of friction").value_or(false);
  map.number("friction_velocity", passive.friction_velocity, kPositive);
  return passive;
}

}  // namespace

RobotSpec read_robot(const YamlReader& reader, const std::filesystem::path& folder) {
  RobotSpec robot{.place = reader.place()};
  YamlMap map(reader, "write '{urdf: robot.urdf}'");
  if (const auto r = map.require("urdf")) {
    robot.urdf = r->name().value_or(Name{});
    robot.path = folder / robot.urdf.value;
  }
  if (const auto r = map.find("base"))
    robot.base = r->choice(kBaseWords, "kind of base").value_or(robot.base);
  if (const auto r = map.find("placement")) {
    robot.placement = read_pose(*r);
    if (robot.base == UrdfOptions::Base::floating)
      r->error("a floating base has no placement", "its position is part of the initial state");
  }
  if (const auto r = map.find("configurations"))
    if (const auto entries = r->named_entries())
      for (const auto& [name, value] : *entries) {
        auto state = read_state(value);
        if (!state) continue;
        if (name.value == "initial")
          reader.diagnostics().error(name.place, "'initial' means the initial state",
                                     "choose another name for the configuration");
        if (state->configuration || !state->robots.empty() || state->state ||
            !state->values.empty() || state->displaced || state->base_velocity ||
            !state->joint_velocities.empty())
          value.error("a configuration has 'base' and 'joints' only");
        robot.configurations.emplace_back(name, std::move(*state));
      }
  if (const auto r = map.find("locked_joints")) robot.locked_joints = read_named_numbers(*r);
  if (const auto r = map.find("payloads"))
    if (const auto entries = r->named_entries())
      for (const auto& [name, value] : *entries)
        robot.payloads.push_back(read_payload(name, value));
  if (const auto r = map.find("external_wrenches"))
    if (const auto items = r->items())
      for (const YamlReader& item : *items) robot.external_wrenches.push_back(read_wrench(item));
  if (const auto r = map.find("rotor_inertia"))
    robot.rotor_inertia = read_named_numbers(*r, kNotNegative);
  if (const auto r = map.find("actuation")) robot.actuation = read_actuation(*r);
  if (const auto r = map.find("passive")) robot.passive = read_passive(*r);
  if (const auto r = map.find("mimic"))
    robot.enforce_mimic = r->choice(kMimicWords, "treatment of mimic joints").value_or(false);
  if (const auto r = map.find("inertias"))
    robot.inertias = r->choice(kInertiasWords, "treatment of inertias").value_or(robot.inertias);
  return robot;
}

}  // namespace conddp
