#include "problem_file/yaml/keys.hpp"

#include <string>

#include <fmt/format.h>

namespace conddp {

std::optional<YamlReader> Keys::found(std::string_view key) {
  YamlMap* map = reading();
  return map != nullptr && map->reader().has(key) ? map->find(key) : std::nullopt;
}

void Keys::error(std::string message, std::string hint) {
  if (YamlMap* map = reading()) map->reader().error(std::move(message), std::move(hint));
}

int Keys::errors() {
  YamlMap* map = reading();
  return map != nullptr ? map->reader().diagnostics().error_count() : 0;
}

void KeyReader::visit(const KeyInfo& key, KeyValue& value) {
  if (const auto reader = key.required ? map_.require(key.name) : map_.find(key.name))
    value.read(*reader);
}

void KeyReader::removed(std::string_view name, std::string_view hint) {
  const YamlReader& reader = map_.reader();
  for (const auto& [key, mark, value] : reader.node().entries) {
    if (key != name) continue;
    map_.find(name);  // so that it is not reported as unknown, too
    const std::string path = fmt::format("{}.{}", reader.place().path, key);
    reader.diagnostics().error({mark, path}, fmt::format("'{}' is no longer an option", path),
                               std::string(hint));
  }
}

void KeyWriter::visit(const KeyInfo& key, KeyValue& value) {
  if (key.omitted) return;
  if (auto expanded = value.expand()) json[std::string(key.name)] = *std::move(expanded);
}

void KeySchema::about(const MapInfo& info) {
  info_ = info;
  if (info.definition.empty()) return;
  const std::string name(info.definition);
  is_known_ = definitions_.contains(name);
  definitions_[name];
}

void KeySchema::visit(const KeyInfo& key, KeyValue& value) {
  if (is_known_) return;
  if (key.required) required_.push_back(key.name);
  OrderedJson schema = value.schema(definitions_), own = OrderedJson::object();
  if (!key.says.empty()) own["description"] = key.says;
  if (!key.fallback.empty()) {
    if (key.fallback != "none") own["default"] = OrderedJson::parse(key.fallback);
  } else if (!key.required && value.has_default()) {
    if (auto fallback = value.expand()) own["default"] = *std::move(fallback);
  }
  if (!key.examples.empty()) own["examples"] = OrderedJson::parse(key.examples);
  // Draft 7 ignores what stands beside a reference.
  if (schema.contains("$ref") && !own.empty())
    schema = {{"allOf", OrderedJson::array({std::move(schema)})}};
  schema.update(own);
  properties_[std::string(key.name)] = std::move(schema);
}

void KeySchema::exclusive(std::initializer_list<std::string_view> keys) {
  if (!is_known_) rules_["not"] = {{"required", keys}};
}

OrderedJson KeySchema::schema() {
  const std::string name(info_.definition);
  const OrderedJson link = {{"$ref", "#/definitions/" + name}};
  if (is_known_) return link;
  OrderedJson schema = {{"type", "object"}, {"title", info_.title}};
  if (!info_.says.empty()) schema["description"] = info_.says;
  schema["properties"] = std::move(properties_);
  if (!required_.empty()) schema["required"] = std::move(required_);
  schema["additionalProperties"] = false;
  schema.update(rules_);
  if (!info_.rules.empty()) schema.update(OrderedJson::parse("{" + std::string(info_.rules) + "}"));
  if (!info_.examples.empty()) schema["examples"] = OrderedJson::parse(info_.examples);
  if (name.empty()) return schema;
  definitions_[name] = std::move(schema);
  return link;
}

void GroupValue::read(const YamlReader& reader) {
  YamlMap map(reader, hint);
  if (!map.valid()) return;
  KeyReader keys(map);
  describe(keys);
}

std::optional<OrderedJson> GroupValue::expand() const {
  KeyWriter keys;
  describe(keys);
  return keys.json.empty() ? std::nullopt : std::optional(std::move(keys.json));
}

OrderedJson GroupValue::schema(SchemaDefinitions& definitions) const {
  KeySchema keys(definitions);
  describe(keys);
  return keys.schema();
}

}  // namespace conddp
