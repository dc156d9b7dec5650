#pragma once

#include <optional>
#include <string>

#include "problem_file/yaml/yaml_node.hpp"

namespace conddp {

/// Reads a text, registered in `out` as `source`, as a single YAML document. Rejected with a
/// diagnostic: syntax errors; an empty document or several documents; anchors, aliases, merge keys
/// and tags; nesting beyond 64; duplicate and non-scalar keys. Marks are moved right by `shift`
/// bytes (a value inside a command-line argument). A null document is accepted if `allow_null`.
std::optional<YamlNode> parse_yaml(const std::string& text, int source, Diagnostics& out,
                                   int shift = 0, bool allow_null = false);

}  // namespace conddp
