#pragma once

#include <string>
#include <string_view>

#include "base/yaml_node.hpp"

namespace conddp {

/// The name of a setting among the texts that Diagnostics knows.
inline constexpr const char* kSettingSource = "--set";

/// Applies a setting `a.b.0.c=value` to a document: names go down into mappings (created where
/// missing), numbers into lists. The value is YAML. Places of what it puts in lie in the setting.
void apply_override(YamlNode& root, const std::string& setting, Diagnostics& out);

/// The part of a mapping or list to which a step of such a key path leads; null where there is
/// none.
YamlNode* find_part(YamlNode& node, std::string_view step);

}  // namespace conddp
