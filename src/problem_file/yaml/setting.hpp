#pragma once

#include <optional>
#include <string>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// The name of a setting among the texts that Diagnostics knows.
inline constexpr const char* kSettingSource = "--set";

/// A value that a key of a problem file has instead of the file's.
struct Setting {
  Name key;          ///< a path as find_node takes it
  YamlNode value;    ///< with places of its own
  std::string text;  ///< "key=value", which parse_setting reads back
};

/// Reads a setting of the command line, `a.b.0.c=value`; the value is YAML. Nothing with an error
/// in the setting where it is none.
std::optional<Setting> parse_setting(const std::string& text, Diagnostics& out);

/// A setting of a value that was written elsewhere.
Setting make_setting(const Name& key, const YamlNode& value);

/// Puts a setting into a document. Names that the document lacks are created.
void apply_setting(YamlNode& root, const Setting& setting, Diagnostics& out);

}  // namespace conddp
