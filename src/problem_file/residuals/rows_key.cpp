#include "problem_file/residuals/rows_key.hpp"

#include <algorithm>

#include "problem_file/spec/expression_source.hpp"
#include "problem_file/values/expand_values.hpp"
#include "problem_file/values/read_values.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {
namespace {

bool in_expressions(const CostSpec& cost) { return cost.definition->name == "expression"; }

/// A mapping of factors, or a list of mappings.
std::vector<NamedNumbers> read_factors(const YamlReader& reader) {
  if (reader.is_map()) return {read_named_numbers(reader)};
  std::vector<NamedNumbers> rows;
  const auto items = reader.items();
  if (!items) return rows;
  if (items->empty()) reader.error("there is no row", "write 'rows: [{theta: 1, omega: 0.5}]'");
  for (const YamlReader& item : *items) rows.push_back(read_named_numbers(item));
  return rows;
}

/// An expression, a list of expressions, or named expressions.
ExpressionRowsSpec read_texts(const YamlReader& reader) {
  ExpressionRowsSpec rows;
  const auto add = [&rows](const YamlReader& row) {
    if (auto text = read_expression(row)) rows.texts.push_back(*std::move(text));
  };
  constexpr std::string_view kHint = "write 'rows: [x^2 + y^2]' or 'rows: {radius: x^2 + y^2}'";
  if (reader.is_map()) {
    const auto entries = reader.named_entries(kHint);
    if (!entries) return rows;
    for (const auto& [name, row] : *entries) {
      rows.names.push_back(name.value);
      add(row);
    }
  } else if (reader.is_sequence()) {
    const auto items = reader.items(kHint);
    if (!items) return rows;
    for (const YamlReader& row : *items) add(row);
  } else {
    add(reader);
    return rows;
  }
  if (rows.texts.empty()) reader.error("there is no row", std::string(kHint));
  return rows;
}

/// True if a text names the previous control: `previous[force]`. The parser reports invalid
/// expressions.
bool names_previous_control(const ExpressionText& text) {
  try {
    ExpressionLexer lexer(text.text);
    while (lexer.next().kind != ExpressionToken::Kind::kEnd)
      if (lexer.take().is(kPreviousControl) && lexer.next().is("[")) return true;
  } catch (const ExpressionError&) {
    return false;
  }
  return false;
}

OrderedJson expand_factors(const std::vector<NamedNumbers>& rows) {
  OrderedJson json = OrderedJson::array();
  for (const NamedNumbers& row : rows) json.push_back(expand_numbers(row));
  return json;
}

OrderedJson expand_texts(const ExpressionRowsSpec& rows) {
  OrderedJson json = rows.names.empty() ? OrderedJson::array() : OrderedJson::object();
  for (std::size_t i = 0; i < rows.texts.size(); ++i) {
    if (rows.names.empty())
      json.push_back(rows.texts[i].text);
    else
      json[rows.names[i]] = rows.texts[i].text;
  }
  return json;
}

}  // namespace

const ResidualKey& rows_key() {
  static const ResidualKey rows = {
      "rows",
      "For expression: an expression, a list of them, or expressions by name. For combination: one "
      "row, or a list of rows, of factors by column of the state (flat ones) or control; "
      "'constant' is added",
      OrderedJson::parse(R"({
        "anyOf": [
          {"$ref": "#/definitions/numbers_by_name"},
          {"type": "object", "additionalProperties": {"$ref": "#/definitions/expression"}},
          {"type": "array", "minItems": 1, "items": {"anyOf": [
            {"$ref": "#/definitions/numbers_by_name"}, {"$ref": "#/definitions/expression"}
          ]}},
          {"$ref": "#/definitions/expression"}
        ],
        "examples": [
          ["x^2 + (y - 1)^2"], {"power": "u[knee]*v[knee]"},
          {"theta": 1, "omega": 0.5, "constant": -2}, [{"q/hip": 1, "q/knee": -1}, {"u/hip": 1}]
        ]
      })"),
      {.required = true},
      [](const YamlReader& reader, CostSpec& cost) {
        if (!in_expressions(cost))
          return cost.keys.set(key::combination_rows, read_factors(reader));
        ExpressionRowsSpec texts = read_texts(reader);
        cost.names_previous_control = std::ranges::any_of(texts.texts, names_previous_control);
        cost.keys.set(key::expression_rows, std::move(texts));
      },
      [](const CostSpec& cost, const KeyContext&) {
        return in_expressions(cost) ? expand_texts(cost.keys.value(key::expression_rows))
                                    : expand_factors(cost.keys.value(key::combination_rows));
      }};
  return rows;
}

}  // namespace conddp
