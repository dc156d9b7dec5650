#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// Nodes that a path creates if the document lacks them.
enum class Missing {
  kCreate,  ///< missing mappings and the value; errors point at the step
  kValue,   ///< only the value, in a mapping below the top; errors point at the key
};

/// The node of a document at a key path such as `phases.reach.dt`. Steps are separated by dots:
/// keys of mappings, and in lists an index from 0 or the `name` of an entry. Names of the document
/// may contain dots; the longest match wins. Returns null with an error if the path leads nowhere.
/// A path that would create a definition with a free name (a parameter, a table, a system) is also
/// an error, because nothing would depend on it.
YamlNode* find_node(YamlNode& root, const Name& key, Missing missing, Diagnostics& out);

/// The node of a document at a key path, or null.
YamlNode* find_present(YamlNode& root, std::string_view key);

/// The part of a mapping or list at a single step, or null.
YamlNode* find_part(YamlNode& node, std::string_view step);

/// The first step of a key path.
std::string_view first_step(std::string_view key);

}  // namespace conddp
