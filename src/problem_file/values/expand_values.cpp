#include "problem_file/values/expand_values.hpp"

namespace conddp {
namespace {

OrderedJson number_or_null(const std::optional<double>& value) {
  return value ? OrderedJson(*value) : OrderedJson(nullptr);
}

}  // namespace

OrderedJson expand_vector(const Vector3<double>& vector) {
  return OrderedJson(std::vector{vector.x, vector.y, vector.z});
}

OrderedJson expand_quaternion(const Quaternion<double>& q) {
  return OrderedJson(std::vector{q.x, q.y, q.z, q.w});
}

OrderedJson expand_numbers(const NamedNumbers& numbers) {
  OrderedJson json = OrderedJson::object();
  for (const auto& [name, value] : numbers) json[name.value] = value;
  return json;
}

OrderedJson expand_components(const ComponentsSpec& spec) {
  if (spec.form == ComponentsSpec::Form::kScalar) return number_or_null(spec.scalar);
  if (spec.form == ComponentsSpec::Form::kList) {
    OrderedJson list = OrderedJson::array();
    for (const auto& value : spec.list) list.push_back(number_or_null(value));
    return list;
  }
  OrderedJson map = OrderedJson::object();
  for (const auto& [name, value] : spec.map) map[name.value] = number_or_null(value);
  return map;
}

OrderedJson expand_symmetric_matrix(const MatrixSpec& matrix) {
  if (matrix.rows.empty()) {
    OrderedJson entries = OrderedJson::object();
    for (const auto& [name, row] : matrix.entries) entries[name.value] = expand_numbers(row);
    return entries;
  }
  OrderedJson rows = OrderedJson::array();
  for (const Located<std::vector<double>>& row : matrix.rows) rows.push_back(row.value);
  return rows;
}

OrderedJson expand_names(const std::vector<Name>& names) {
  OrderedJson list = OrderedJson::array();
  for (const Name& name : names) list.push_back(name.value);
  return list;
}

OrderedJson expand_motion(const PlanarMotion& motion) {
  return OrderedJson(std::vector{motion.x, motion.y, motion.yaw});
}

OrderedJson expand_pose(const PoseSpec& pose) {
  OrderedJson json = OrderedJson::object();
  if (pose.position) json["position"] = expand_vector(*pose.position);
  if (pose.orientation) json["orientation"] = expand_quaternion(*pose.orientation);
  return json;
}

OrderedJson expand_twist(const TwistSpec& twist) {
  return {{"linear", expand_vector(twist.linear)}, {"angular", expand_vector(twist.angular)}};
}

namespace {

OrderedJson expand_base(const BaseSpec& base) {
  OrderedJson json = OrderedJson::object();
  if (base.position) json["position"] = *base.position;
  if (base.orientation) json["orientation"] = expand_quaternion(*base.orientation);
  if (base.yaw) json["yaw"] = *base.yaw;
  return json;
}

/// Position and velocity of base and joints.
void expand_posture(const StateSpec& state, OrderedJson& json) {
  if (state.base) json["base"] = expand_base(*state.base);
  if (state.displaced) json["displaced"] = expand_motion(state.displaced->motion);
  if (!state.joints.empty()) json["joints"] = expand_numbers(state.joints);
  if (state.base_velocity) json["velocity"]["base"] = expand_twist(*state.base_velocity);
  if (!state.joint_velocities.empty())
    json["velocity"]["joints"] = expand_numbers(state.joint_velocities);
}

}  // namespace

OrderedJson expand_state(const StateSpec& state) {
  OrderedJson json = OrderedJson::object();
  if (state.configuration) json["configuration"] = state.configuration->value;
  expand_posture(state, json);
  for (const auto& [name, part] : state.robots) json["robots"][name.value] = expand_state(part);
  if (state.state) json["state"] = *state.state;
  if (!state.values.empty()) json["values"] = expand_numbers(state.values);
  if (state.previous_control) json["previous_control"] = expand_components(*state.previous_control);
  return json;
}

OrderedJson expand_data_file(const DataFileSpec& file) {
  OrderedJson json = {{"file", file.file.value}};
  if (!file.columns.empty()) json["columns"] = expand_names(file.columns);
  return json;
}

OrderedJson expand_contact_names(const ContactNames& names, const ProblemSpec& spec) {
  if (!names.all) return expand_names(names.names);
  OrderedJson all = OrderedJson::array();
  for (const ContactSpec& contact : spec.contacts) all.push_back(contact.name.value);
  return all;
}

}  // namespace conddp
