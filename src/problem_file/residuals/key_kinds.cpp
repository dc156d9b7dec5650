#include "problem_file/residuals/key_kinds.hpp"

#include "problem_file/values/expand_values.hpp"
#include "problem_file/values/read_values.hpp"
#include "problem_file/values/value_schema.hpp"

namespace conddp {
ResidualKey name_key(const Key<Name>& key, std::string_view description, KeyTraits traits) {
  return {key.name,
          description,
          {{"type", "string"}, {"minLength", 1}},
          std::move(traits),
          [&key](const YamlReader& reader, CostSpec& cost) {
            if (const auto name = reader.name()) cost.keys.set(key, *name);
          },
          [&key](const CostSpec& cost, const KeyContext&) {
            const Name* name = cost.keys.find(key);
            return name != nullptr ? OrderedJson(name->value) : OrderedJson(nullptr);
          }};
}

ResidualKey names_key(const Key<std::vector<Name>>& key, std::string_view description,
                      KeyTraits traits) {
  const OrderedJson name = {{"type", "string"}, {"minLength", 1}};
  const OrderedJson names = {{"type", "array"}, {"items", name}, {"uniqueItems", true}};
  return {key.name,
          description,
          {{"anyOf", OrderedJson::array({name, names})}},
          std::move(traits),
          [&key](const YamlReader& reader, CostSpec& cost) {
            if (auto given = reader.name_or_names()) cost.keys.set(key, std::move(*given));
          },
          [&key](const CostSpec& cost, const KeyContext&) {
            const std::vector<Name>* given = cost.keys.find(key);
            return given != nullptr ? expand_names(*given) : OrderedJson(nullptr);
          }};
}

ResidualKey number_key(const Key<double>& key, std::string_view description,
                       const NumberRange& range, KeyTraits traits) {
  OrderedJson schema = range_schema(range);
  schema["default"] = key.fallback;
  return {key.name,
          description,
          std::move(schema),
          std::move(traits),
          [&key, range](const YamlReader& reader, CostSpec& cost) {
            if (const auto number = reader.number(range)) cost.keys.set(key, *number);
          },
          [&key](const CostSpec& cost, const KeyContext&) {
            return OrderedJson(cost.keys.value(key));
          }};
}

ResidualKey integer_key(const Key<int>& key, std::string_view description, int lower, int upper,
                        KeyTraits traits) {
  return {key.name,
          description,
          {{"type", "integer"}, {"minimum", lower}, {"maximum", upper}, {"default", key.fallback}},
          std::move(traits),
          [&key, lower, upper](const YamlReader& reader, CostSpec& cost) {
            if (const auto number = reader.integer(lower, upper))
              cost.keys.set(key, static_cast<int>(*number));
          },
          [&key](const CostSpec& cost, const KeyContext&) {
            return OrderedJson(cost.keys.value(key));
          }};
}

ResidualKey flag_key(const Key<bool>& key, std::string_view description, KeyTraits traits) {
  return {key.name,
          description,
          {{"type", "boolean"}, {"default", key.fallback}},
          std::move(traits),
          [&key](const YamlReader& reader, CostSpec& cost) {
            static constexpr Choice<bool> kWords[] = {{"true", true}, {"false", false}};
            const std::string what = "value of '" + std::string(key.name) + "'";
            if (const auto flag = reader.choice(kWords, what)) cost.keys.set(key, *flag);
          },
          [&key](const CostSpec& cost, const KeyContext&) {
            return OrderedJson(cost.keys.value(key));
          }};
}

ResidualKey components_key(const Key<ComponentsSpec>& key, std::string_view description,
                           KeyTraits traits) {
  return {key.name,
          description,
          defined_schema("components"),
          std::move(traits),
          [&key](const YamlReader& reader, CostSpec& cost) {
            if (auto given = read_components(reader)) cost.keys.set(key, std::move(*given));
          },
          [&key](const CostSpec& cost, const KeyContext&) {
            const ComponentsSpec* given = cost.keys.find(key);
            return given != nullptr ? expand_components(*given) : OrderedJson(0.0);
          }};
}

}  // namespace conddp
