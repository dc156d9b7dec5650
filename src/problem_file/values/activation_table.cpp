#include "problem_file/values/activation_table.hpp"

#include <algorithm>

#include "problem_file/values/expand_values.hpp"
#include "problem_file/values/read_values.hpp"
#include "problem_file/values/value_schema.hpp"

namespace conddp {
namespace {

constexpr std::string_view kOfBarriers = "bounds belong to the activation 'quadratic_barrier'";

OrderedJson expand_bounds(const std::optional<ComponentsSpec>& bounds) {
  return bounds ? expand_components(*bounds) : OrderedJson(nullptr);
}

OrderedJson epsilon_schema() {
  OrderedJson schema = range_schema(kPositive);
  schema["default"] = ActivationSpec().epsilon;
  return schema;
}

void read_source(const YamlReader& reader, ActivationSpec& activation) {
  static constexpr Choice<bool> kWords[] = {{"urdf", true}};
  activation.from_urdf = reader.choice(kWords, "source of bounds").value_or(false);
}

/// Keys of all activations in the order of output.
const std::vector<const ActivationKey*>& activation_keys() {
  static const std::vector<const ActivationKey*> keys = [] {
    std::vector<const ActivationKey*> all;
    for (const ActivationDefinition& definition : activation_table())
      for (const ActivationKey* key : definition.keys)
        if (std::find(all.begin(), all.end(), key) == all.end()) all.push_back(key);
    return all;
  }();
  return keys;
}

/// The named activation, or null.
const ActivationDefinition* choose_activation(const YamlReader& reader) {
  std::vector<std::string> words;
  for (const ActivationDefinition& definition : activation_table())
    words.emplace_back(definition.name);
  const auto index = reader.choose(words, "activation");
  return index ? &activation_table()[*index] : nullptr;
}

}  // namespace

std::span<const ActivationDefinition> activation_table() {
  static const ActivationKey from = {"from",
                                     "Take the barrier's bounds from the robot's limits",
                                     {{"enum", OrderedJson::array({"urdf"})}},
                                     kOfBarriers,
                                     read_source,
                                     [](const ActivationSpec& a) {
                                       return a.from_urdf ? OrderedJson("urdf")
                                                          : OrderedJson(nullptr);
                                     }};
  static const ActivationKey lower = {
      "lower",
      "Lower bounds of a barrier, in the residual's units; null: none",
      defined_schema("limits"),
      kOfBarriers,
      [](const YamlReader& reader, ActivationSpec& a) { a.lower = read_component_bounds(reader); },
      [](const ActivationSpec& a) { return expand_bounds(a.lower); }};
  static const ActivationKey upper = {
      "upper",
      "Upper bounds of a barrier, in the residual's units; null: none",
      defined_schema("limits"),
      kOfBarriers,
      [](const YamlReader& reader, ActivationSpec& a) { a.upper = read_component_bounds(reader); },
      [](const ActivationSpec& a) { return expand_bounds(a.upper); }};
  static const ActivationKey epsilon = {
      "epsilon",
      "Width of the smooth norms, in the residual's unit",
      epsilon_schema(),
      "'epsilon' belongs to the smooth norms",
      [](const YamlReader& reader, ActivationSpec& a) {
        a.epsilon = reader.number(kPositive).value_or(a.epsilon);
      },
      [](const ActivationSpec& a) { return OrderedJson(a.epsilon); }};
  static const ActivationDefinition all[] = {
      {.name = "quadratic", .kind = ActivationKind::quadratic, .description = "½ Σ w r²"},
      {.name = "quadratic_barrier",
       .kind = ActivationKind::quadratic_barrier,
       .description =
           "½ Σ w r² of what lies outside bounds; needs 'lower', 'upper' or 'from: urdf'",
       .keys = {&from, &lower, &upper},
       .needs = "a barrier needs its bounds",
       .hint = "write '{kind: quadratic_barrier, lower: ..., upper: ...}' or 'from: urdf'"},
      {.name = "smooth_l1",
       .kind = ActivationKind::smooth_l1,
       .description = "Σ w (√(r² + ε²) − ε); takes 'epsilon'",
       .keys = {&epsilon}},
      {.name = "smooth_l2",
       .kind = ActivationKind::smooth_l2,
       .description = "√(Σ w r² + ε²) − ε; takes 'epsilon'",
       .keys = {&epsilon}},
      {.name = "linear",
       .kind = ActivationKind::linear,
       .description = "Σ w r, a cost that can be negative"}};
  return all;
}

const ActivationDefinition& activation_definition(ActivationKind kind) {
  const auto table = activation_table();
  return *std::find_if(table.begin(), table.end(),
                       [&](const ActivationDefinition& d) { return d.kind == kind; });
}

namespace {

void report_need(const YamlReader& reader, const ActivationDefinition& definition) {
  if (!definition.needs.empty())
    reader.error(std::string(definition.needs), std::string(definition.hint));
}

/// Reads the keys except `kind`, and reports those that a known activation does not accept. Returns
/// true if any key is present.
bool read_activation_keys(YamlMap& map, const ActivationDefinition* definition,
                          ActivationSpec& activation) {
  bool any = false;
  for (const ActivationKey* key : activation_keys()) {
    const auto value = map.find(key->name);
    if (!value) continue;
    any = true;
    key->read(*value, activation);
    if (definition == nullptr) continue;
    const auto& own = definition->keys;
    if (std::find(own.begin(), own.end(), key) == own.end()) value->error(std::string(key->unfit));
  }
  return any;
}

}  // namespace

ActivationSpec read_activation(const YamlReader& reader) {
  ActivationSpec activation{.place = reader.place()};
  if (reader.is_scalar()) {
    const ActivationDefinition* definition = choose_activation(reader);
    if (definition == nullptr) return activation;
    activation.kind = definition->kind;
    report_need(reader, *definition);
    return activation;
  }
  YamlMap map(reader);
  const auto kind = map.require("kind");
  const ActivationDefinition* definition = kind ? choose_activation(*kind) : nullptr;
  const bool any = read_activation_keys(map, definition, activation);
  if (definition == nullptr) return activation;
  activation.kind = definition->kind;
  if (!any) report_need(reader, *definition);
  return activation;
}

OrderedJson expand_activation(const ActivationSpec& activation) {
  const ActivationDefinition& definition = activation_definition(activation.kind);
  if (definition.keys.empty()) return OrderedJson(definition.name);
  OrderedJson json = {{"kind", definition.name}};
  for (const ActivationKey* key : definition.keys)
    if (OrderedJson value = key->expand(activation); !value.is_null())
      json[std::string(key->name)] = std::move(value);
  return json;
}

}  // namespace conddp
