#include "problem_file/yaml/yaml_node.hpp"

#include "base/text/strict_number.hpp"

namespace conddp {

const YamlNode* YamlNode::find(std::string_view key) const {
  for (const Entry& entry : entries)
    if (entry.key == key) return &entry.value;
  return nullptr;
}

std::string_view kind_name(const YamlNode& node) {
  switch (node.kind) {
    case YamlNode::Kind::kNull:
      return "nothing";
    case YamlNode::Kind::kSequence:
      return "a list";
    case YamlNode::Kind::kMap:
      return "a mapping";
    case YamlNode::Kind::kScalar:
      break;
  }
  if (node.quoted) return "a quoted text";
  return parse_number(node.text).value ? "a number" : "a word";
}

}  // namespace conddp
