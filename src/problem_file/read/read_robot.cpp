#include <algorithm>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

/// kg m²; the six entries as in URDF, off-diagonal entries zero by default.
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

/// Reads a number, or the name of one of the robot's parameters.
void read_mass(const YamlReader& reader, const NamedNumbers& parameters, PayloadSpec& payload) {
  const std::string& text = reader.node().text;
  const bool is_parameter =
      reader.is_scalar() && std::ranges::any_of(parameters, [&](const auto& parameter) {
        return parameter.first.value == text;
      });
  if (is_parameter)
    payload.mass_parameter = Name{text, reader.place()};
  else
    payload.mass = reader.number(kPositive).value_or(0);
}

PayloadSpec read_payload(const Name& link, const YamlReader& reader,
                         const NamedNumbers& parameters) {
  PayloadSpec payload{.link = link};
  YamlMap map(reader);
  if (const auto r = map.require("mass")) read_mass(*r, parameters, payload);
  read_vector3(map, "com", "[x, y, z] in m", payload.com);
  map.read("inertia", payload.inertia, read_inertia);
  return payload;
}

WrenchSpec read_wrench(const YamlReader& reader) {
  WrenchSpec spec;
  YamlMap map(reader);
  if (const auto r = map.require("frame")) spec.frame = r->name().value_or(Name{});
  read_vector3(map, "force", "[x, y, z] in N", spec.wrench.linear);
  read_vector3(map, "torque", "[x, y, z] in Nm", spec.wrench.angular);
  return spec;
}

PassiveSpec read_passive(const YamlReader& reader) {
  PassiveSpec passive;
  YamlMap map(reader);
  map.choice("damping", passive.damping, kPassiveWords, "source of damping");
  map.choice("friction", passive.friction, kPassiveWords, "source of friction");
  map.number("friction_velocity", passive.friction_velocity, kPositive);
  return passive;
}

/// True if a state has more than the position of base and joints.
bool says_more_than_a_posture(const StateSpec& state) {
  return state.configuration || !state.robots.empty() || state.state || !state.values.empty() ||
         state.displaced || state.base_velocity || !state.joint_velocities.empty();
}

void read_configuration(const Name& name, const YamlReader& reader, RobotSpec& robot) {
  auto state = read_state(reader);
  if (!state) return;
  if (name.value == "initial")
    reader.diagnostics().error(name.place, "'initial' means the initial state",
                               "choose another name for the configuration");
  if (says_more_than_a_posture(*state))
    reader.error("a configuration has 'base' and 'joints' only");
  robot.configurations.emplace_back(name, std::move(*state));
}

/// Reads the robot's file, placement and named configurations.
void read_body(YamlMap& map, const std::filesystem::path& folder, RobotSpec& robot) {
  if (const auto r = map.require("urdf")) {
    robot.urdf = r->name().value_or(Name{});
    robot.path = folder / robot.urdf.value;
  }
  map.choice("base", robot.base, kBaseWords, "kind of base");
  if (const auto r = map.find("placement")) {
    robot.placement = read_pose(*r);
    if (robot.base == UrdfOptions::Base::floating)
      r->error("a floating base has no placement", "its position is part of the initial state");
  }
  for_each_entry(map, "configurations", [&](const Name& name, const YamlReader& value) {
    read_configuration(name, value, robot);
  });
}

/// Reads changes of the URDF's masses and loads on the robot.
void read_loads(YamlMap& map, RobotSpec& robot) {
  if (const auto r = map.find("locked_joints")) robot.locked_joints = read_named_numbers(*r);
  if (const auto r = map.find("parameters")) robot.parameters = read_named_numbers(*r);
  for_each_entry(map, "payloads", [&](const Name& name, const YamlReader& value) {
    robot.payloads.push_back(read_payload(name, value, robot.parameters));
  });
  for_each_item(map, "external_wrenches", [&](const YamlReader& item) {
    robot.external_wrenches.push_back(read_wrench(item));
  });
  if (const auto r = map.find("rotor_inertia"))
    robot.rotor_inertia = read_named_numbers(*r, kNotNegative);
}

}  // namespace

RobotSpec read_robot(const YamlReader& reader, const std::filesystem::path& folder) {
  RobotSpec robot{.place = reader.place()};
  YamlMap map(reader, "write '{urdf: robot.urdf}'");
  read_body(map, folder, robot);
  read_loads(map, robot);
  map.read("actuation", robot.actuation, read_actuation);
  map.read("passive", robot.passive, read_passive);
  map.choice("mimic", robot.enforce_mimic, kMimicWords, "treatment of mimic joints");
  map.choice("inertias", robot.inertias, kInertiasWords, "treatment of inertias");
  return robot;
}

}  // namespace conddp
