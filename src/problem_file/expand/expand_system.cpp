#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/values/system_keys.hpp"

namespace conddp {
namespace {

OrderedJson expand_columns(const std::vector<Column>& columns) {
  OrderedJson json = OrderedJson::object();
  for (const Column& column : columns) json[column.name] = column.unit;
  return json;
}

OrderedJson expand_states(const std::vector<ExpressionState>& states) {
  OrderedJson json = OrderedJson::object();
  for (const ExpressionState& state : states)
    json[state.name] = state.kind == ExpressionState::Kind::kUnitQuaternion ? "unit_quaternion"
                       : state.kind == ExpressionState::Kind::kPose         ? "pose"
                                                                            : state.unit;
  return json;
}

OrderedJson expand_expressions(const std::vector<NamedExpression>& expressions) {
  OrderedJson json = OrderedJson::object();
  for (const NamedExpression& expression : expressions) json[expression.name] = expression.text;
  return json;
}

OrderedJson expand_points(const TableSpec& table) {
  if (table.points.size() == 1) return {{"points", table.points[0]}, {"values", table.values}};
  const std::size_t columns = table.points[1].size();
  OrderedJson rows = OrderedJson::array();
  for (auto row = table.values.begin(); row != table.values.end(); row += columns)
    rows.push_back(std::vector<double>(row, row + columns));
  return {{"points", table.points}, {"values", std::move(rows)}};
}

}  // namespace

OrderedJson expand_parameters(const NamedParameters& parameters) {
  OrderedJson json = OrderedJson::object();
  for (const auto& [name, value] : parameters)
    json[name] = value.is_vector ? OrderedJson(value.numbers) : OrderedJson(value.numbers[0]);
  return json;
}

OrderedJson expand_tables(const std::vector<TableSpec>& tables) {
  OrderedJson json = OrderedJson::object();
  for (const TableSpec& table : tables) json[table.name.value] = expand_points(table);
  return json;
}

namespace {

void expand(const ExpressionSystemSpec& p, OrderedJson& json) {
  const ExpressionSystemText& text = p.text;
  const bool second_order = text.kind == SystemKind::second_order;
  json[second_order ? "positions" : "states"] = expand_states(text.states);
  if (second_order) json["velocities"] = expand_columns(text.velocities);
  json["controls"] = expand_columns(text.controls);
  json["parameters"] = expand_parameters(p.own.parameters);
  json["tables"] = expand_tables(p.own.tables);
  json["let"] = expand_expressions(text.definitions);
  json[second_order                           ? "acceleration"
       : text.kind == SystemKind::first_order ? "rate"
                                              : "next"] = expand_expressions(text.equations);
}

void expand(const LibrarySystemSpec& p, OrderedJson& json) {
  const LibrarySystemColumns& columns = p.columns;
  const bool second_order = columns.kind == SystemKind::second_order;
  json["library"] = p.function.library.value;
  json["function"] = p.function.function.value;
  json["gives"] = word_of(kLibraryAnswerWords, columns.kind);
  json[second_order ? "positions" : "states"] = expand_columns(columns.states);
  if (second_order) json["velocities"] = expand_columns(columns.velocities);
  json["controls"] = expand_columns(columns.controls);
  json["parameters"] = expand_numbers(p.function.parameters);
}

}  // namespace

OrderedJson expand_system(const SystemSpec& system) {
  OrderedJson json = expand_map(system);
  if (const auto* expressions = std::get_if<ExpressionSystemSpec>(&system.parameters))
    expand(*expressions, json);
  if (const auto* library = std::get_if<LibrarySystemSpec>(&system.parameters))
    expand(*library, json);
  return json;
}

}  // namespace conddp
