#pragma once

#include <string>

#include "problem_file/spec/residual_definition.hpp"

namespace conddp {

/// Keys of residuals by the type of their value, with schema, reader and expansion.

ResidualKey name_key(const Key<Name>& key, std::string_view description, KeyTraits traits = {});
/// A list of names, or a single name.
ResidualKey names_key(const Key<std::vector<Name>>& key, std::string_view description,
                      KeyTraits traits = {});
ResidualKey number_key(const Key<double>& key, std::string_view description,
                       const NumberRange& range, KeyTraits traits = {});
ResidualKey integer_key(const Key<int>& key, std::string_view description, int lower, int upper,
                        KeyTraits traits = {});
ResidualKey flag_key(const Key<bool>& key, std::string_view description, KeyTraits traits = {});
/// Numbers by component, expanded to the number 0 if missing.
ResidualKey components_key(const Key<ComponentsSpec>& key, std::string_view description,
                           KeyTraits traits = {});
/// A word of a table. `what`: "system of axes".
template <class E, std::size_t N>
ResidualKey choice_key(const Key<E>& key, std::string_view description, std::string_view what,
                       const Choice<E> (&table)[N], KeyTraits traits = {}) {
  const auto word = [&table](E value) {
    for (const Choice<E>& entry : table)
      if (entry.value == value) return OrderedJson(std::string(entry.word));
    return OrderedJson(nullptr);
  };
  OrderedJson schema = {{"enum", OrderedJson::array()}};
  for (const Choice<E>& entry : table) schema["enum"].push_back(std::string(entry.word));
  schema["default"] = word(key.fallback);
  return {
      key.name,
      description,
      std::move(schema),
      std::move(traits),
      [&key, &table, what](const YamlReader& reader, CostSpec& cost) {
        if (const auto value = reader.choice(table, what)) cost.keys.set(key, *value);
      },
      [&key, word](const CostSpec& cost, const KeyContext&) { return word(cost.keys.value(key)); }};
}

}  // namespace conddp
