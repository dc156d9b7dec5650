#include <algorithm>

#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/values/activation_keys.hpp"

namespace conddp {
namespace {

/// Rows of numbers, or numbers by the names of their row and column.
struct SymmetricMatrixForm {
  bool read(const YamlReader& reader, MatrixSpec& matrix) const {
    constexpr std::string_view kHint = "write '[[2, 1], [1, 3]]' or '{x: {x: 2, v: 1}, v: {v: 3}}'";
    matrix.place = reader.place();
    if (reader.is_map()) {
      const auto entries = reader.named_entries(kHint);
      for (const auto& [name, row] : *entries)
        NamedNumbersForm().read(row, matrix.entries.emplace_back(name, NamedNumbers()).second);
      return true;
    }
    const auto rows = reader.items(kHint);
    if (!rows) return false;
    for (const YamlReader& row : *rows) {
      const auto numbers = row.numbers();
      if (!numbers) return false;
      matrix.rows.push_back({*numbers, row.place()});
    }
    return true;
  }
  std::optional<OrderedJson> expand(const MatrixSpec& matrix) const {
    OrderedJson json = matrix.rows.empty() ? OrderedJson::object() : OrderedJson::array();
    for (const auto& [name, row] : matrix.entries)
      json[name.value] = *NamedNumbersForm().expand(row);
    for (const Located<std::vector<double>>& row : matrix.rows) json.push_back(row.value);
    return json;
  }
  OrderedJson schema() const { return {{"$ref", "#/definitions/matrix"}}; }
};

/// Reads the activation, or sets the residual's default.
void describe_activation(Keys& keys, CostSpec& cost) {
  const ResidualDefinition* definition = cost.definition;
  const bool is_cone = definition != nullptr && definition->is_cone;
  YamlMap* map = keys.reading();
  const auto given = map != nullptr ? map->find("activation") : std::nullopt;
  if (map != nullptr && (is_cone || !given) && definition->set_activation != nullptr)
    definition->set_activation(cost);
  if (given && is_cone)
    given->error("a cone has its own bounds, outside of which it costs: it has no activation",
                 "leave the key out");
  else
    keys({.name = "activation", .omitted = is_cone || is_excluded("activation", cost)},
         cost.activation, ActivationForm{});
}

void check_matrix(YamlMap& map, const CostSpec& cost) {
  map.exclusive({"weights", "matrix"});
  const auto matrix = map.find("matrix");
  if (matrix && cost.activation.kind != ActivationKind::quadratic)
    matrix->error(
        fmt::format("'matrix' belongs to the activation 'quadratic', and this cost has '{}'",
                    word_of(kActivationWords, cost.activation.kind)),
        "write 'weights', one per row");
}

}  // namespace

void describe_phases(Keys& keys, std::string_view says, std::optional<std::vector<Name>>& phases) {
  keys({"phases", says}, phases, NameOrNamesForm{{}, "phase"});
}

void describe_knots(Keys& keys, std::string_view says, CostSpec& cost) {
  keys({"knots", says}, cost.knots, KnotsForm{});
}

bool describe_function(Keys& keys, std::string_view says, CostSpec& cost) {
  if (!describe_residual(keys, cost, says)) return false;
  if (const auto residual = keys.found("residual");
      residual && cost.where.last_node && !cost.definition->at_last_node())
    residual->error(
        fmt::format("the residual '{}' needs a control, and there is none at the terminal node",
                    cost.definition->name));
  return true;
}

void describe(Keys& keys, CostSpec& cost) {
  if (cost.where.last_node)
    keys.about({.definition = "terminal_cost",
                .title = "Cost on the last node",
                .says = "weight · a(r) of a residual r and an activation a",
                .examples = R"([{"residual": "frame_placement", "frame": "tool", "weight": 10000,
                                 "reference": {"position": [0.3, 0, 0.4], "rpy": [0, 0, 0]}}])"});
  else
    keys.about({.definition = "cost",
                .title = "Running cost",
                .says = "weight · a(r) of a residual r and an activation a; multiplied by the time "
                        "step where running_costs is rate",
                .examples = R"([{"residual": "control", "weight": 0.001, "phases": ["swing"]}])"});
  if (!describe_function(keys, "What is to be small", cost)) return;
  keys({"weight", "Factor of the cost, in the cost's unit per unit of the activation"}, cost.weight,
       NumberForm{kNotNegative});
  keys({.name = "weights",
        .says = "Factors of the components besides the weight, not negative; 1 where nothing is "
                "said",
        .fallback = "1"},
       cost.weights, ComponentsForm{kNotNegative});
  keys({"matrix", "W of ½ rᵀ W r instead of weights, of the activation quadratic"}, cost.matrix,
       SymmetricMatrixForm{});
  describe_activation(keys, cost);
  keys({.name = "reference",
        .says = "What the residual is measured from",
        .omitted = is_excluded("reference", cost)},
       cost, OriginForm{});
  if (YamlMap* map = keys.reading()) check_matrix(*map, cost);
  if (cost.where.last_node) return;
  describe_phases(keys, "Phases in which it counts, names may have a *; all by default",
                  cost.phases);
  describe_knots(
      keys,
      "Knots at which it counts: numbers from 0 over all phases, or a phase, its first knot, "
      "and 'phase + 3'; all by default",
      cost);
}

namespace {

void reject_keys_of_costs(YamlMap& map) {
  const auto residual = map.find("residual"), reference = map.find("reference");
  if (map.find("knots"))
    map.reader().error("an integral grows at all knots of its phases", "leave 'knots' out");
  if (reference || (residual && residual->node().text != "expression"))
    map.reader().error("an integral is an expression, without a reference",
                       "write it as 'rows', and other residuals below 'of'");
}

void describe_integral(Keys& keys, CostSpec& integral) {
  keys.about({.title = "Integral by its keys",
              .examples = R"([{"rows": "u[elbow]*v[elbow]", "phases": "lift"}])"});
  integral.definition = find_residual("expression");
  if (YamlMap* map = keys.reading()) {
    integral.residual = {"expression", map->reader().place()};
    reject_keys_of_costs(*map);
  }
  keys({"residual", "May be left out"},
       CustomValue{[](const YamlReader&) {}, [] { return OrderedJson("expression"); },
                   R"({"const": "expression"})"});
  for (const ResidualKey* key : integral.definition->keys) {
    KeyInfo info = key->info;
    info.required = key->traits.required;
    if (info.required) {  // its rows
      info.says = "One expression";
      info.examples = R"(["u[elbow]*v[elbow]"])";
    }
    key->visit(keys, info, integral);
  }
  describe_phases(keys, "Phases in which it grows, names may have a *; all by default",
                  integral.phases);
}

}  // namespace

bool IntegralsForm::read(const YamlReader& reader, std::vector<CostSpec>& integrals) const {
  const auto entries = reader.named_entries("write '{energy: u*v}'");
  if (!entries) return false;
  for (const auto& [name, value] : *entries) {
    CostSpec& integral = integrals.emplace_back();
    integral.name = name;
    integral.where.kind = TermPlace::Kind::kIntegral;
    YamlNode rows{.kind = YamlNode::Kind::kMap, .mark = value.node().mark};
    rows.entries.push_back({"rows", rows.mark, value.node()});
    GroupValue([&](Keys& keys) { describe_integral(keys, integral); },
               "write an expression, as 'energy: u*v'")
        .read(value.is_scalar() ? value.at(rows, value.place().path) : value);
  }
  return true;
}

std::optional<OrderedJson> IntegralsForm::expand(const std::vector<CostSpec>& integrals) const {
  OrderedJson json = OrderedJson::object();
  for (CostSpec integral : integrals)
    json[integral.name.value] =
        *GroupValue([&](Keys& keys) { describe_integral(keys, integral); }).expand();
  return json.empty() ? std::nullopt : std::optional(std::move(json));
}

OrderedJson IntegralsForm::schema(const std::vector<CostSpec>& /*names the type*/,
                                  SchemaDefinitions& definitions) const {
  const OrderedJson integral = defined(definitions, "integral", [&] {
    CostSpec none;
    const GroupValue keys([&](Keys& own) { describe_integral(own, none); });
    return OrderedJson{
        {"title", "Integral"},
        {"anyOf", {ExpressionForm().schema({}, definitions), keys.schema(definitions)}},
        {"examples", OrderedJson::parse(R"(["u[elbow]*v[elbow]"])")}};
  });
  return {{"type", "object"}, {"additionalProperties", integral}};
}

}  // namespace conddp
