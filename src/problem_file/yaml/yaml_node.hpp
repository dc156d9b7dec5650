#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/text/diagnostic.hpp"

namespace conddp {

/// A node of a YAML document: a value that owns its children, with places of keys and values. Nodes
/// of yaml-cpp are shared, convert freely between types, and lose the places of keys.
struct YamlNode {
  enum class Kind { kNull, kScalar, kSequence, kMap };
  struct Entry;

  Kind kind = Kind::kNull;
  Mark mark;
  std::string text;     ///< of a scalar
  bool quoted = false;  ///< a scalar in quotes or a block scalar: always a string
  std::vector<YamlNode> items;
  std::vector<Entry> entries;

  const YamlNode* find(std::string_view key) const;
};

struct YamlNode::Entry {
  std::string key;
  Mark mark;  ///< of the key
  YamlNode value;
};

/// Names a node's kind in messages: "a number", "a list", ...
std::string_view kind_name(const YamlNode& node);

}  // namespace conddp
