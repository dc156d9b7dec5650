#include "systems/expressions/model_texts.hpp"

namespace conddp {

void ModelTextReader::report(Part part, int index, std::string message, std::string hint) {
  errors_.push_back({part, index, false, {0, std::move(message), std::move(hint)}});
}

void ModelTextReader::report_text(Part part, int index, std::string message, std::string hint) {
  errors_.push_back({part, index, true, {0, std::move(message), std::move(hint)}});
}

bool ModelTextReader::check_name(Part part, int index, const std::string& name) {
  std::string defect = time_is_known_ && name == "t" ? "'t' is the time" : scope_.defect_of(name);
  if (defect.empty()) return true;
  report(part, index, std::move(defect));
  return false;
}

void ModelTextReader::add(Part part, int index, const std::string& name, ExpressionValue value) {
  if (check_name(part, index, name)) scope_.add(name, std::move(value));
}

void ModelTextReader::add_parameters(const NamedParameters& parameters) {
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto& [name, given] = parameters[i];
    ExpressionValue value = ExpressionValue::vector({});
    for (const double number : given.numbers) value.nodes.push_back(graph_.constant(number));
    if (!given.is_vector) value.kind = ExpressionValue::Kind::kNumber;
    add(Part::kParameter, static_cast<int>(i), name, std::move(value));
  }
}

void ModelTextReader::add_tables(const NamedTables& tables) {
  for (std::size_t i = 0; i < tables.size(); ++i) {
    const auto& [name, table] = tables[i];
    if (check_name(Part::kTable, static_cast<int>(i), name))
      scope_.add_table(name, graph_.add_table(table), table->arguments());
  }
}

void ModelTextReader::add_definitions(const std::vector<NamedExpression>& definitions) {
  for (const NamedExpression& definition : definitions)
    scope_.explain(definition.name,
                   "it is defined further below; definitions use those before them");
  for (std::size_t i = 0; i < definitions.size() && good(); ++i) {
    const int index = static_cast<int>(i);
    const bool named = check_name(Part::kDefinition, index, definitions[i].name);
    auto value = parse(Part::kDefinition, index, definitions[i].text);
    if (named && value) scope_.add(definitions[i].name, std::move(*value));
  }
}

std::optional<ExpressionValue> ModelTextReader::parse(Part part, int index,
                                                      const std::string& text) {
  ParsedExpression parsed = parse_expression(text, scope_, graph_);
  if (!parsed.value) errors_.push_back({part, index, true, parsed.error});
  for (ExpressionMessage& warning : parsed.warnings)
    warnings_.push_back({part, index, true, std::move(warning)});
  return parsed.value;
}

}  // namespace conddp
