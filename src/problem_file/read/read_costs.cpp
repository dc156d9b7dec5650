#include <algorithm>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "problem_file/values/activation_table.hpp"

namespace conddp {
namespace {

std::vector<Located<int>> read_knots(const YamlReader& reader) {
  std::vector<Located<int>> knots;
  if (const auto items = reader.items())
    for (const YamlReader& item : *items)
      if (const auto knot = item.integer(0, 1'000'000)) {
        for (const Located<int>& former : knots)
          if (former.value == *knot) item.error(fmt::format("{} stands twice in the list", *knot));
        knots.push_back({static_cast<int>(*knot), item.place()});
      }
  return knots;
}

/// The residual that is named, or null.
const ResidualDefinition* choose_residual(const YamlReader& reader) {
  std::vector<std::string> words;
  std::vector<Synonyms> synonyms;
  for (const ResidualDefinition* definition : residual_table()) {
    words.emplace_back(definition->name);
    synonyms.push_back({definition->name, definition->synonyms});
  }
  const auto index = reader.choose(words, "residual", synonyms);
  return index ? residual_table()[*index] : nullptr;
}

/// A key of residuals, which only some of them have.
void read_key(YamlMap& map, const ResidualKey& key, CostSpec& cost) {
  const auto& own = cost.definition->keys;
  const bool fits = std::find(own.begin(), own.end(), &key) != own.end();
  const KeyTraits& traits = key.traits;
  const auto value = fits && traits.required ? map.require(key.name) : map.find(key.name);
  if (!value) return;
  if (fits || !traits.required) key.read(*value, cost);
  if (!fits)
    value->error(fmt::format("the residual '{}' has no '{}'", cost.residual.value, key.name));
  if (!traits.excludes.empty()) map.exclusive({key.name, traits.excludes});
}

CostSpec read_cost(const Name& name, const YamlReader& reader, const std::filesystem::path& folder,
                   bool terminal) {
  CostSpec cost{.name = name};
  YamlMap map(reader);
  if (!map.valid() || !read_residual(map, folder, {.last_node = terminal}, cost)) return cost;
  const ResidualDefinition& definition = *cost.definition;
  map.number("weight", cost.weight, kNotNegative);
  const auto activation = map.find("activation");
  if (definition.set_activation != nullptr && (!activation || definition.is_cone))
    definition.set_activation(cost);
  if (activation && definition.is_cone)
    activation->error("a cone has its own bounds, outside of which it costs: it has no activation",
                      "leave the key out");
  else if (activation)
    cost.activation = read_activation(*activation);
  if (const auto r = map.find("weights")) cost.weights = read_components(*r, kNotNegative);
  return cost;
}

}  // namespace

bool read_residual(YamlMap& map, const std::filesystem::path& folder, TermPlace place,
                   CostSpec& cost) {
  const auto residual = map.require("residual");
  const ResidualDefinition* found = residual ? choose_residual(*residual) : nullptr;
  if (found == nullptr) {
    map.ignore_others();
    return false;
  }
  const ResidualDefinition& definition = *found;
  cost.definition = &definition;
  cost.residual = {std::string(definition.name), residual->place()};
  for (const ResidualKey* key : residual_keys())
    if (key->stands_in(place)) read_key(map, *key, cost);
  if (const auto r = map.find("reference")) {
    if (definition.reference != nullptr)
      cost.reference = read_reference(*r, cost, folder);
    else
      r->error(fmt::format("the residual '{}' has no reference", definition.name));
  }
  if (place.last_node) {
    if (!definition.at_last_node())
      residual->error(
          fmt::format("the residual '{}' needs a control, and there is none at the terminal node",
                      definition.name));
    return true;
  }
  if (const auto r = map.find("phases")) cost.phases = r->name_or_names();
  if (const auto r = map.find("knots")) cost.knots = read_knots(*r);
  return true;
}

std::vector<CostSpec> read_costs(const YamlReader& reader, const std::filesystem::path& folder,
                                 bool terminal) {
  std::vector<CostSpec> costs;
  if (const auto entries = reader.named_entries("write '{effort: {residual: control}}'"))
    for (const auto& [name, value] : *entries)
      costs.push_back(read_cost(name, value, folder, terminal));
  return costs;
}

}  // namespace conddp
