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
