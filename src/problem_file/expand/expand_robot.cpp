#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

OrderedJson expand_payload(const PayloadSpec& payload) {
  const auto& parameter = payload.mass_parameter;
  OrderedJson json = {
      {"mass", parameter ? OrderedJson(parameter->value) : OrderedJson(payload.mass)},
      {"com", expand_vector(payload.com)}};
  if (const auto& I = payload.inertia)
    json["inertia"] = {{"ixx", I->xx}, {"iyy", I->yy}, {"izz", I->zz},
                       {"ixy", I->xy}, {"ixz", I->xz}, {"iyz", I->yz}};
  return json;
}

OrderedJson expand_thruster(const ThrusterSpec& thruster) {
  return {{"name", thruster.name.value},
          {"frame", thruster.frame.value},
          {"direction", expand_vector(thruster.direction)},
          {"torque_ratio", thruster.torque_ratio},
          {"lower", finite_or_null(thruster.lower)},
          {"upper", finite_or_null(thruster.upper)}};
}

OrderedJson expand_actuation(const ActuationSpec& actuation) {
  if (actuation.full || (actuation.joints.empty() && actuation.thrusters.empty()))
    return OrderedJson(word_of(kActuationWords, actuation.full));
  OrderedJson thrusters = OrderedJson::array();
  for (const ThrusterSpec& thruster : actuation.thrusters)
    thrusters.push_back(expand_thruster(thruster));
  return {{"joints", expand_names(actuation.joints)}, {"thrusters", std::move(thrusters)}};
}

/// Missing parts take the world's origin and axes.
OrderedJson expand_placement(PoseSpec placement) {
  if (!placement.position) placement.position = Vector3<double>::zero();
  if (!placement.orientation) placement.orientation = Quaternion<double>::identity();
  return expand_pose(placement);
}

}  // namespace

OrderedJson expand_robot(const RobotSpec& robot) {
  OrderedJson json = {{"urdf", robot.urdf.value}, {"base", word_of(kBaseWords, robot.base)}};
  if (robot.base != UrdfOptions::Base::floating)
    json["placement"] = expand_placement(robot.placement.value_or(PoseSpec{}));
  OrderedJson configurations = OrderedJson::object();
  for (const auto& [name, state] : robot.configurations)
    configurations[name.value] = expand_state(state);
  json["configurations"] = std::move(configurations);
  json["locked_joints"] = expand_numbers(robot.locked_joints);
  json["parameters"] = expand_numbers(robot.parameters);
  OrderedJson payloads = OrderedJson::object();
  for (const PayloadSpec& payload : robot.payloads)
    payloads[payload.link.value] = expand_payload(payload);
  json["payloads"] = std::move(payloads);
  OrderedJson wrenches = OrderedJson::array();
  for (const WrenchSpec& wrench : robot.external_wrenches)
    wrenches.push_back({{"frame", wrench.frame.value},
                        {"force", expand_vector(wrench.wrench.linear)},
                        {"torque", expand_vector(wrench.wrench.angular)}});
  json["external_wrenches"] = std::move(wrenches);
  json["rotor_inertia"] = expand_numbers(robot.rotor_inertia);
  json["actuation"] = expand_actuation(robot.actuation);
  json["passive"] = {{"damping", word_of(kPassiveWords, robot.passive.damping)},
                     {"friction", word_of(kPassiveWords, robot.passive.friction)},
                     {"friction_velocity", robot.passive.friction_velocity}};
  json["mimic"] = word_of(kMimicWords, robot.enforce_mimic);
  json["inertias"] = word_of(kInertiasWords, robot.inertias);
  return json;
}

}  // namespace conddp
