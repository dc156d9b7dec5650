#pragma once

#include <optional>
#include <string>
#include <vector>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// The name of a setting among the sources of Diagnostics.
inline constexpr const char* kSettingSource = "--set";

/// A value that replaces the file's value of a key.
struct Setting {
  Name key;          ///< a path as in find_node
  YamlNode value;    ///< with its own places
  std::string text;  ///< "key=value", which parse_setting reads back
};

/// Reads a setting of the command line, `a.b.0.c=value`; the value is YAML. Empty with an error in
/// the setting if it is malformed.
std::optional<Setting> parse_setting(const std::string& text, Diagnostics& out);

/// Reads several settings; malformed ones are reported and left out.
std::vector<Setting> parse_settings(const std::vector<std::string>& texts, Diagnostics& out);

/// A setting from a value that was read elsewhere.
Setting make_setting(const Name& key, const YamlNode& value);

/// Applies a setting to a document. Missing names are created.
void apply_setting(YamlNode& root, const Setting& setting, Diagnostics& out);

}  // namespace conddp
