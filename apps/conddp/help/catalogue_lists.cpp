#include "help/catalogue_lists.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "arguments/example_problems.hpp"
#include "help/embedded_schemas.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/model/system_fields.hpp"
#include "problem_file/read/problem_schema.hpp"
#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/values/activation_keys.hpp"
#include "solvers/common/option_table.hpp"
#include "solvers/strategies/registry.hpp"
#include "systems/expressions/functions.hpp"

namespace conddp {
namespace {

const OrderedJson& definitions() {
  static const OrderedJson schema = OrderedJson::parse(find_schema("problem")->text);
  return schema.at("definitions");
}

/// A key of an object in the problem file's schema.
OrderedJson schema_key(const OrderedJson& object, const std::string& name) {
  const OrderedJson& schema = object.at("properties").at(name);
  OrderedJson entry = {
      {"name", name}, {"description", schema.at("description")}, {"required", false}};
  if (schema.contains("default")) entry["default"] = schema["default"];
  return entry;
}

OrderedJson list_solvers() {
  OrderedJson list = OrderedJson::array();
  list.push_back({{"name", kAutoSolver}, {"description", kAutoMeaning}});
  for (const SolverInfo& info : solvers()) {
    const char* bounds = info.control_bounds == BoundSupport::exact     ? "exact"
                         : info.control_bounds == BoundSupport::clipped ? "clipped"
                                                                        : "refused";
    OrderedJson hessians = OrderedJson::array();
    if (info.gauss_newton_hessian) hessians.push_back("gauss_newton");
    if (info.exact_hessian) hessians.push_back("exact");
    list.push_back({{"name", info.name},
                    {"description", info.description},
                    {"control_bounds", bounds},
                    {"starts_from", info.open_gaps ? "states and controls" : "controls"},
                    {"hessian", std::move(hessians)}});
  }
  return list;
}

void add_range(const OptionInfo& info, OrderedJson& entry) {
  entry[info.min_excluded ? "more_than" : "at_least"] = info.min;
  if (std::isfinite(info.max)) entry[info.max_excluded ? "less_than" : "at_most"] = info.max;
}

OrderedJson list_options() {
  OrderedJson list = OrderedJson::array();
  for (const OptionInfo& info : option_table()) {
    OrderedJson entry = {{"name", info.name}, {"description", info.doc}};
    std::visit([&](const auto& value) { entry["default"] = value; }, info.default_value());
    if (entry["default"].is_number_float() && !std::isfinite(entry["default"].get<double>()))
      entry["default"] = nullptr;
    if (info.choices.empty())
      add_range(info, entry);
    else
      entry["choices"] = info.choices;
    list.push_back(std::move(entry));
  }
  return list;
}

/// Lists the keys of a mapping with the schemas of their values.
class KeyList final : public Keys {
 public:
  bool documents() const override { return true; }
  void visit(const KeyInfo& key, KeyValue& value) override {
    if (key.omitted) return;
    SchemaDefinitions none;
    KeySchema described(none);
    described.visit(key, value);
    OrderedJson schema = described.schema()["properties"][std::string(key.name)];
    OrderedJson entry = {
        {"name", key.name}, {"description", schema["description"]}, {"required", key.required}};
    if (schema.contains("default")) entry["default"] = schema["default"];
    schema.erase("description");
    entry["schema"] = std::move(schema);
    list.push_back(std::move(entry));
  }
  OrderedJson list = OrderedJson::array();
};

OrderedJson residual_key(const ResidualDefinition& definition, const ResidualKey& own) {
  KeyList keys;
  CostSpec cost;
  KeyInfo info = own.info;
  info.required = own.traits.required;
  own.visit(keys, info, cost);
  OrderedJson entry = std::move(keys.list[0]), places = OrderedJson::array();
  for (const auto kind : {TermPlace::Kind::kCost, TermPlace::Kind::kConstraint})
    for (const bool last_node : {false, true})
      if (own.stands_in({kind, last_node}) && (definition.at_last_node() || !last_node))
        places.push_back(std::string(last_node ? "terminal." : "") +
                         (kind == TermPlace::Kind::kCost ? "costs" : "constraints"));
  entry["places"] = std::move(places);
  return entry;
}

OrderedJson list_residuals() {
  OrderedJson list = OrderedJson::array();
  for (const ResidualDefinition* definition : residual_table()) {
    OrderedJson keys = OrderedJson::array();
    for (const ResidualKey* own : definition->keys) keys.push_back(residual_key(*definition, *own));
    if (definition->reference != nullptr)
      keys.push_back(schema_key(definitions().at("cost"), "reference"));
    list.push_back({{"name", definition->name},
                    {"description", definition->description},
                    {"unit", definition->unit},
                    {"needs_robot", definition->needs.robot},
                    {"at_terminal_node", definition->at_last_node()},
                    {"keys", std::move(keys)}});
  }
  return list;
}

/// The keys of a struct besides the first, which names its kind.
template <class T>
OrderedJson other_keys(T value) {
  KeyList keys;
  describe(keys, value);
  keys.list.erase(0);
  return std::move(keys.list);
}

OrderedJson list_activations() {
  OrderedJson list = OrderedJson::array();
  for (const auto& choice : kActivationWords)
    list.push_back({{"name", choice.word},
                    {"description", choice.description},
                    {"needs_keys", choice.value == ActivationKind::quadratic_barrier},
                    {"keys", other_keys(ActivationSpec{.kind = choice.value})}});
  return list;
}

OrderedJson list_systems() {
  OrderedJson list = OrderedJson::array();
  for (std::size_t i = 0; i < std::size(kSystemTypes); ++i)
    list.push_back({{"name", kSystemTypes[i].name},
                    {"description", kSystemTypes[i].description},
                    {"keys", other_keys(default_system(i))}});
  return list;
}

OrderedJson list_integrators() {
  OrderedJson list = OrderedJson::array();
  for (const auto& choice : kIntegratorWords)
    list.push_back({{"name", choice.word}, {"description", choice.description}});
  return list;
}

OrderedJson list_constraints() {
  const OrderedJson& constraint = definitions().at("constraint");
  OrderedJson list = OrderedJson::array();
  for (const auto& choice : kBoundedWords) {
    OrderedJson keys = OrderedJson::array();
    for (const auto& [name, schema] : constraint.at("properties").items())
      if (name != "bounds") keys.push_back(schema_key(constraint, name));
    list.push_back(
        {{"name", choice.word}, {"description", choice.description}, {"keys", std::move(keys)}});
  }
  return list;
}

OrderedJson list_functions() {
  OrderedJson list = OrderedJson::array();
  for (const ExpressionFunction& function : expression_functions()) {
    OrderedJson arguments = OrderedJson::array();
    for (const auto& argument : function.arguments) arguments.push_back(argument.name);
    list.push_back({{"name", function.name},
                    {"description", function.documentation},
                    {"arguments", std::move(arguments)}});
  }
  for (const ExpressionConstant& constant : expression_constants())
    list.push_back({{"name", constant.name}, {"description", constant.documentation}});
  return list;
}

OrderedJson list_problems() {
  OrderedJson list = OrderedJson::array();
  for (const std::filesystem::path& file : example_problems()) {
    std::string summary = example_summary(file);
    if (summary.empty()) summary = "(no description)";
    list.push_back(
        {{"name", file.stem().string()}, {"description", summary}, {"file", file.string()}});
  }
  return list;
}

constexpr ListKind kKinds[] = {
    {"solvers", "solver: {name: ...}, or --solver", list_solvers},
    {"options", "solver: {option: ..., group: {option: ...}}", list_options},
    {"residuals", "costs: {NAME: {residual: ...}}", list_residuals},
    {"activations", "costs: {NAME: {activation: ...}}, with keys {activation: {kind: ...}}",
     list_activations},
    {"systems", "system: {type: ...}", list_systems},
    {"integrators", "integrator: ...", list_integrators},
    {"constraints", "constraints: {NAME: {bounds: ...}}", list_constraints},
    {"functions", "expressions: system: {rate: {NAME: ...}}", list_functions},
    {"problems", "examples: conddp solve NAME, conddp bench", list_problems},
};

}  // namespace

std::span<const ListKind> list_kinds() { return kKinds; }

}  // namespace conddp
