#include "problem_file/read/problem_schema.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/spec/system_fields.hpp"
#include "problem_file/values/activation_table.hpp"
#include "problem_file/values/system_keys.hpp"

namespace conddp {

const std::string_view kAutoMeaning =
    "the default, by the problem: ipopt for contact-implicit problems, altro, proxddp and ipopt "
    "one after the other where there are constraints besides bounds on the control, else box_fddp "
    "and ipopt (conddp check says which)";

namespace {

/// True for the schema of a number, or of a list of numbers.
bool is_numeric(const OrderedJson& schema) {
  if (!schema.contains("type")) return false;
  const OrderedJson& type = schema["type"];
  const auto has = [&](const char* word) {
    return type == word || (type.is_array() && std::ranges::find(type, word) != type.end());
  };
  return has("number") || has("integer") ||
         (has("array") && schema.contains("items") && is_numeric(schema["items"]));
}

/// Accepts a formula, "=2*mass", in place of a number or a list of numbers.
void accept_formulas(OrderedJson& part) {
  if (part.is_object() && is_numeric(part)) {
    OrderedJson& type = part["type"];
    if (!type.is_array()) type = OrderedJson::array({type});
    if (std::ranges::find(type, "string") == type.end()) {
      type.push_back("string");
      part["pattern"] = "^=";
    }
  }
  if (part.is_array())
    for (OrderedJson& item : part) accept_formulas(item);
  if (!part.is_object()) return;
  for (auto& [key, value] : part.items())
    if (key != "default" && key != "examples" && key != "enum" && key != "const")
      accept_formulas(value);
}

/// The schema of a key's value, with its description.
template <class Documented>
OrderedJson key_schema(const Documented& key) {
  OrderedJson schema = key.schema;
  schema["description"] = key.description;
  return schema;
}

template <class Named>
OrderedJson names_of(const Named& all) {
  OrderedJson names = OrderedJson::array();
  for (const auto& one : all) names.push_back(one.name);
  return names;
}

/// "name: description; name: description".
template <class Named>
std::string meanings_of(const Named& all) {
  std::string meanings;
  for (const auto& one : all)
    meanings += fmt::format("{}{}: {}", meanings.empty() ? "" : "; ", one.name, one.description);
  return meanings;
}

void add_residuals(const char* definition, TermPlace place, OrderedJson& schema) {
  OrderedJson& properties = schema["definitions"][definition]["properties"];
  OrderedJson names = OrderedJson::array();
  for (const ResidualDefinition* residual : residual_table()) {
    if (place.last_node && !residual->at_last_node()) continue;
    names.push_back(residual->name);
    for (const ResidualKey* key : residual->keys)
      if (key->stands_in(place)) properties[std::string(key->name)] = key_schema(*key);
  }
  properties["residual"]["enum"] = std::move(names);
}

void add_activations(OrderedJson& activation) {
  activation["description"] = "How a residual r becomes a cost: " + meanings_of(activation_table());
  OrderedJson words = OrderedJson::array();
  OrderedJson& properties = activation["anyOf"][1]["properties"];
  properties["kind"]["enum"] = names_of(activation_table());
  for (const ActivationDefinition& definition : activation_table()) {
    if (definition.needs.empty()) words.push_back(definition.name);
    for (const ActivationKey* key : definition.keys)
      properties[std::string(key->name)] = key_schema(*key);
  }
  activation["anyOf"][0]["enum"] = std::move(words);
}

void add_systems(OrderedJson& branches) {
  SchemaDefinitions none;
  for (std::size_t i = 0; i < std::size(kSystemTypes); ++i) {
    SystemSpec system = default_system(i);
    KeySchema keys(none);
    describe(keys, system);
    if (kSystemTypes[i].examples.empty())  // its keys depend on each other
      branches[i]["properties"]["type"] = keys.schema()["properties"]["type"];
    else
      branches[i] = keys.schema();
  }
}

std::string flat(const OrderedJson& value) {
  if (value.is_number_float() && value.get<double>() == std::round(value.get<double>()))
    return fmt::format("{:.0f}", value.get<double>());
  if (!value.is_structured()) return value.dump();
  std::string text;
  for (const auto& [key, item] : value.items())
    text += (text.empty() ? "" : ", ") +
            (value.is_object() ? OrderedJson(key).dump() + ": " : std::string()) + flat(item);
  return value.is_object() ? "{" + text + "}" : "[" + text + "]";
}

/// `head`: length of the key before the value.
std::string folded(const OrderedJson& value, std::size_t indent, std::size_t head) {
  constexpr std::size_t kWidth = 120;
  std::string line = flat(value);
  if (!value.is_structured() || indent + head + line.size() < kWidth) return line;
  std::string text;
  for (const auto& [key, item] : value.items()) {
    const std::string name = value.is_object() ? OrderedJson(key).dump() + ": " : "";
    text += fmt::format("{}{:{}}{}{}", text.empty() ? "\n" : ",\n", "", indent + 2, name,
                        folded(item, indent + 2, name.size()));
  }
  const std::string end = fmt::format("\n{:{}}", "", indent);
  return value.is_object() ? "{" + text + end + "}" : "[" + text + end + "]";
}

}  // namespace

OrderedJson problem_schema(OrderedJson schema) {
  OrderedJson& definitions = schema["definitions"];
  SchemaDefinitions described = {{"data_file", definitions["data_file"]}};
  map_schema<MeshSpec>(described);
  map_schema<RobotSpec>(described);
  map_schema<CandidateSpec>(described);
  map_schema<SteppingSpec>(described);
  map_schema<Perturbation>(described);
  map_schema<SolverSpec>(described);
  schema["properties"]["contacts"].update(ContactsForm().schema({}, described));
  schema["properties"]["collision"].update(map_schema<CollisionSpec>(described));
  GuessSpec guess;
  GaitSpec gait;
  MpcSpec mpc;
  PhaseSpec phase;
  for (const auto& describe_it : std::initializer_list<std::function<void(Keys&)>>{
           [&](Keys& keys) { describe(keys, guess, {}); },
           [&](Keys& keys) { describe(keys, gait, {}); },
           [&](Keys& keys) { describe(keys, mpc, {}); },
           [&](Keys& keys) { describe(keys, phase, nullptr); }})
    GroupValue(describe_it).schema(described);
  definitions.update(described);
  add_residuals("cost", {}, schema);
  add_residuals("terminal_cost", {.last_node = true}, schema);
  add_residuals("residual_constraint", {.constraint = true}, schema);
  add_residuals("terminal_constraint", {.constraint = true, .last_node = true}, schema);
  add_activations(definitions["activation"]);
  add_systems(definitions["system"]["oneOf"]);
  OrderedJson integrators = OrderedJson::array();
  for (const auto& choice : kIntegratorWords) integrators.push_back(choice.word);
  schema["properties"]["integrator"]["enum"] = std::move(integrators);
  accept_formulas(schema);
  return schema;
}

std::string schema_text(const OrderedJson& schema) { return folded(schema, 0, 0) + "\n"; }

}  // namespace conddp
