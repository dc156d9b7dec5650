#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// What a path creates where the document has nothing.
enum class Missing {
  kCreate,  ///< every mapping on the way, and the value; errors are at the step
  kValue,   ///< the value alone, in a mapping below the top; errors are at the key
};

/// The node of a document to which a key path such as `phases.reach.dt` leads. Steps have dots
/// between them: the keys of mappings; in lists an index from 0, or the `name` of an entry. A name
/// that the document has may itself have dots; of several the longest counts. Null with an error
/// where it leads nowhere, and where it would create a definition by a free name (a parameter, a
/// table, a system): nothing would depend on that.
YamlNode* find_node(YamlNode& root, const Name& key, Missing missing, Diagnostics& out);

/// The node of a document to which a key path leads; null where the document has none.
YamlNode* find_present(YamlNode& root, std::string_view key);

/// The part of a mapping or list to which one step leads; null where there is none.
YamlNode* find_part(YamlNode& node, std::string_view step);

/// The first step of a key path.
std::string_view first_step(std::string_view key);

}  // namespace conddp
