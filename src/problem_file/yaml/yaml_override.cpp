#include "problem_file/yaml/yaml_override.hpp"

#include <algorithm>
#include <charconv>
#include <utility>

#include <fmt/format.h>

#include "base/utf8.hpp"
#include "problem_file/yaml/yaml_source.hpp"

namespace conddp {
namespace {

constexpr int kMaxLevels = 64;

/// The child that a step of the path leads to; nothing with an error where there is none.
YamlNode* descend(YamlNode& node, const std::string& step, const Place& place, Diagnostics& out) {
  if (node.kind == YamlNode::Kind::kNull) {
    node = {.kind = YamlNode::Kind::kMap, .mark = place.mark};
  }
  if (YamlNode* part = find_part(node, step)) return part;
  if (node.kind == YamlNode::Kind::kMap) {
    node.entries.push_back({step, place.mark, {.mark = place.mark}});
    return &node.entries.back().value;
  }
  if (node.kind == YamlNode::Kind::kSequence) {
    out.error(place, fmt::format("'{}' is not an index into a list of {}", step, node.items.size()),
              "indices start at 0");
    return nullptr;
  }
  out.error(place,
            fmt::format("'{}' leads into {}, which has no parts", place.path, kind_name(node)));
  return nullptr;
}

}  // namespace

YamlNode* find_part(YamlNode& node, std::string_view step) {
  if (node.kind == YamlNode::Kind::kMap) {
    for (YamlNode::Entry& entry : node.entries)
      if (entry.key == step) return &entry.value;
  } else if (node.kind == YamlNode::Kind::kSequence) {
    std::size_t index = 0;
    const char* end = step.data() + step.size();
    const auto [stop, code] = std::from_chars(step.data(), end, index);
    if (code == std::errc() && stop == end && index < node.items.size()) return &node.items[index];
  }
  return nullptr;
}

void apply_override(YamlNode& root, const std::string& setting, Diagnostics& out) {
  const int source = out.add_source(kSettingSource, setting);
  if (const std::size_t bad = find_bad_character(setting); bad != std::string::npos) {
    const int column = out.character_column(source, 1, static_cast<int>(bad));
    return out.error({{source, 1, column}, {}}, describe_bad_character(setting, bad));
  }
  const std::size_t equals = setting.find('=');
  if (equals == std::string::npos || equals == 0) {
    out.error({{source, 1, 1}, {}}, fmt::format("'{}' is not a setting", setting),
              "write --set key.path=value, for example --set solver.max_iterations=50");
    return;
  }
  if (std::count(setting.begin(), setting.begin() + static_cast<long>(equals), '.') >= kMaxLevels)
    return out.error({{source, 1, 1}, {}},
                     fmt::format("the key path is deeper than {} levels", kMaxLevels));
  YamlNode* node = &root;
  for (std::size_t start = 0; start < equals;) {
    const std::size_t end = std::min(setting.find('.', start), equals);
    const std::string step = setting.substr(start, end - start);
    const Place place{{source, 1, out.character_column(source, 1, static_cast<int>(start))},
                      setting.substr(0, end)};
    if (step.empty()) return out.error(place, "a name in the key path is empty");
    node = descend(*node, step, place, out);
    if (node == nullptr) return;
    start = end + 1;
  }
  const auto value =
      parse_yaml(setting.substr(equals + 1), source, out, static_cast<int>(equals) + 1, true);
  if (value) *node = *value;
}

}  // namespace conddp
