#include "problem_file/residuals/residual_keys.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "problem_file/residuals/residual_table.hpp"

namespace conddp {
namespace {

/// The named residual, or null.
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

/// Hint with the residuals that have a key, and the alternative of the others.
std::string owners_hint(const ResidualKey& key) {
  std::string hint;
  for (const ResidualDefinition* definition : residual_table())
    if (std::ranges::find(definition->keys, &key) != definition->keys.end())
      hint +=
          fmt::format("{}{}", hint.empty() ? "residuals that have it: " : ", ", definition->name);
  return key.traits.instead.empty() ? hint : fmt::format("{}; {}", hint, key.traits.instead);
}

/// Reads a key that only some residuals have.
void read_key(YamlMap& map, const ResidualKey& key, CostSpec& cost) {
  const auto& own = cost.definition->keys;
  const bool fits = std::find(own.begin(), own.end(), &key) != own.end();
  const KeyTraits& traits = key.traits;
  const auto value = fits && traits.required ? map.require(key.name) : map.find(key.name);
  if (!value) return;
  if (fits || !traits.required) key.read(*value, cost);
  if (!fits)
    value->error(fmt::format("the residual '{}' has no '{}'", cost.residual.value, key.name),
                 owners_hint(key));
  if (!traits.excludes.empty()) map.exclusive({key.name, traits.excludes});
}

}  // namespace

bool read_residual_keys(YamlMap& map, TermPlace place, CostSpec& cost) {
  const auto residual = map.require("residual");
  const ResidualDefinition* found = residual ? choose_residual(*residual) : nullptr;
  if (found == nullptr) {
    map.ignore_others();
    return false;
  }
  cost.definition = found;
  cost.residual = {std::string(found->name), residual->place()};
  for (const ResidualKey* key : residual_keys())
    if (key->stands_in(place)) read_key(map, *key, cost);
  return true;
}

OrderedJson expand_residual_keys(const CostSpec& cost, const KeyContext& context) {
  OrderedJson json = {{"residual", cost.residual.value}};
  for (const ResidualKey* key : cost.definition->keys)
    if (OrderedJson value = key->expand(cost, context); !value.is_null())
      json[std::string(key->name)] = std::move(value);
  return json;
}

}  // namespace conddp
