#include "problem_file/yaml/setting.hpp"

#include <string_view>
#include <utility>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "base/text/utf8.hpp"
#include "problem_file/yaml/key_path.hpp"
#include "problem_file/yaml/yaml_source.hpp"

namespace conddp {
namespace {

std::string quoted(const std::string& text) {
  return nlohmann::json(text).dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

/// A key in flow style, quoted if it is ambiguous.
std::string flow_key(const std::string& key) {
  const bool plain = key.find_first_not_of(
                         "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ"
                         "0123456789_/") == std::string::npos;
  return plain && !key.empty() ? key : quoted(key);
}

/// A value on one line. Numbers keep their notation.
std::string flow_text(const YamlNode& node) {
  std::string text;
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      return "null";
    case YamlNode::Kind::kScalar:
      return node.quoted ? quoted(node.text) : node.text;
    case YamlNode::Kind::kSequence:
      for (const YamlNode& item : node.items) text += (text.empty() ? "" : ", ") + flow_text(item);
      return '[' + text + ']';
    case YamlNode::Kind::kMap:
      for (const YamlNode::Entry& entry : node.entries)
        text += (text.empty() ? "" : ", ") + flow_key(entry.key) + ": " + flow_text(entry.value);
      return '{' + text + '}';
  }
  return text;
}

/// True if the text begins like a number and contains only characters of a number.
bool is_plain_number(std::string_view text) {
  const std::size_t first = text.find_first_not_of("+-.");
  return first <= 2 && text[first] >= '0' && text[first] <= '9' &&
         text.find_first_not_of("+-.0123456789eE") == std::string_view::npos;
}

/// The value of a setting, which begins `shift` characters into its text.
std::optional<YamlNode> parse_value(const std::string& value, int source, int shift,
                                    Diagnostics& out) {
  // Batches have millions of numbers, and starting a YAML parser is slow.
  if (is_plain_number(value))
    return YamlNode{.kind = YamlNode::Kind::kScalar,
                    .mark = {source, 1, out.character_column(source, 1, shift)},
                    .text = value};
  return parse_yaml(value, source, out, shift, true);
}

}  // namespace

std::optional<Setting> parse_setting(const std::string& text, Diagnostics& out) {
  const int source = out.add_source(kSettingSource, text);
  if (const std::size_t bad = find_bad_character(text); bad != std::string::npos) {
    const int column = out.character_column(source, 1, static_cast<int>(bad));
    out.error({{source, 1, column}, {}}, describe_bad_character(text, bad));
    return std::nullopt;
  }
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0) {
    out.error({{source, 1, 1}, {}}, fmt::format("'{}' is not a setting", text),
              "write --set key.path=value, for example --set solver.max_iterations=50");
    return std::nullopt;
  }
  auto value = parse_value(text.substr(equals + 1), source, static_cast<int>(equals) + 1, out);
  if (!value) return std::nullopt;
  const std::string key = text.substr(0, equals);
  return Setting{{key, {{source, 1, 1}, key}}, *std::move(value), text};
}

std::vector<Setting> parse_settings(const std::vector<std::string>& texts, Diagnostics& out) {
  std::vector<Setting> settings;
  for (const std::string& text : texts)
    if (auto setting = parse_setting(text, out)) settings.push_back(*std::move(setting));
  return settings;
}

Setting make_setting(const Name& key, const YamlNode& value) {
  return {key, value, key.value + '=' + flow_text(value)};
}

void apply_setting(YamlNode& root, const Setting& setting, Diagnostics& out) {
  if (YamlNode* node = find_node(root, setting.key, Missing::kCreate, out)) *node = setting.value;
}

}  // namespace conddp
