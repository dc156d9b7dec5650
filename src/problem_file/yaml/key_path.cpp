#include "problem_file/yaml/key_path.hpp"

#include <algorithm>
#include <charconv>
#include <initializer_list>
#include <optional>
#include <vector>

#include <fmt/format.h>

#include "base/text/spelling.hpp"
#include "base/text/utf8.hpp"

namespace conddp {
namespace {

constexpr std::ptrdiff_t kMaxLevels = 64;

const std::string* name_of(const YamlNode& entry) {
  if (entry.kind != YamlNode::Kind::kMap) return nullptr;
  const YamlNode* name = entry.find("name");
  return name != nullptr && name->kind == YamlNode::Kind::kScalar ? &name->text : nullptr;
}

/// The names accepted as a step at a node.
std::vector<std::string> names_at(const YamlNode& node) {
  std::vector<std::string> names;
  for (const YamlNode::Entry& entry : node.entries) names.push_back(entry.key);
  for (const YamlNode& item : node.items)
    if (const std::string* name = name_of(item)) names.push_back(*name);
  return names;
}

/// Length of the first step of `path` at a node. The step is the longest name there that is a
/// prefix of the path, dots included, or else the text before the first dot.
std::size_t step_length(const YamlNode& node, std::string_view path) {
  std::size_t length = 0;
  for (const std::string& name : names_at(node))
    if (name.size() > length && path.starts_with(name) &&
        (name.size() == path.size() || path[name.size()] == '.'))
      length = name.size();
  return length > 0 ? length : first_step(path).size();
}

using Steps = std::vector<std::string>;

/// True if the mapping at the end of the steps holds definitions with free names. A new definition
/// there has no effect, because the rest of the file does not name it. (Other settings may name a
/// new configuration of a robot.)
bool has_definitions(const Steps& steps) {
  const auto is_one_of = [](const std::string& word, std::initializer_list<std::string_view> all) {
    return std::find(all.begin(), all.end(), word) != all.end();
  };
  if (steps.empty()) return false;
  const std::string &section = steps.front(), &key = steps.back();
  const auto is_in = [&](std::string_view one, std::string_view several) {
    return (steps.size() == 2 && section == one) || (steps.size() == 3 && section == several);
  };
  if (steps.size() == 1) return is_one_of(key, {"parameters", "tables", "systems"});
  return is_in("system", "systems") && is_one_of(key, {"parameters", "tables", "let"});
}

std::string joined(const Steps& steps) {
  std::string path;
  for (const std::string& step : steps) path += (path.empty() ? "" : ".") + step;
  return path;
}

/// Follows a key path.
class Walk {
 public:
  Walk(const Name& key, Missing missing, Diagnostics& out)
      : key_(key), missing_(missing), out_(out) {}

  YamlNode* from(YamlNode& root) {
    const std::string& key = key_.value;
    if (std::count(key.begin(), key.end(), '.') >= kMaxLevels)
      return fail(0, 0, fmt::format("the key path is deeper than {} levels", kMaxLevels));
    YamlNode* node = &root;
    for (std::size_t start = 0; node != nullptr && start <= key.size();) {
      const std::size_t end = step_end(*node, start);
      if (start == end) return fail(start, end, "a name in the key path is empty");
      node = descend(*node, start, end);
      before_.push_back(key.substr(start, end - start));
      start = end + 1;
    }
    return node;
  }

 private:
  /// End of the step that begins at `start`. Keys below `mpc.plant.set` are paths themselves: the
  /// entire rest is the key if the file does not contain it.
  std::size_t step_end(YamlNode& node, std::size_t start) const {
    const std::string_view rest = std::string_view(key_.value).substr(start);
    const std::size_t length = step_length(node, rest);
    const bool is_path = before_ == Steps{"mpc", "plant", "set"};
    const bool is_new = is_path && find_part(node, rest.substr(0, length)) == nullptr;
    return start + (is_new ? rest.size() : length);
  }

  YamlNode* fail(std::size_t start, std::size_t end, std::string message, std::string hint = {},
                 std::vector<std::string> accepted = {}) {
    out_.error(place_of(start, end), std::move(message), std::move(hint), std::move(accepted));
    return nullptr;
  }

  /// Place of a step, or of the entire key if only its value may be missing.
  Place place_of(std::size_t start, std::size_t end) const {
    if (missing_ == Missing::kValue) return {key_.place.mark, key_.value};
    Place place{key_.place.mark, key_.value.substr(0, end)};
    place.mark.column += count_characters(std::string_view(key_.value).substr(0, start));
    return place;
  }

  YamlNode* descend(YamlNode& node, std::size_t start, std::size_t end) {
    const std::string step = key_.value.substr(start, end - start);
    const Mark mark = place_of(start, end).mark;
    if (node.kind == YamlNode::Kind::kNull && missing_ == Missing::kCreate) {
      if (is_index(step)) return report_missing_list(step, start, end);
      node = {.kind = YamlNode::Kind::kMap, .mark = mark};
    }
    if (YamlNode* part = find_part(node, step)) return part;
    const bool creates = missing_ == Missing::kCreate || (start > 0 && end == key_.value.size());
    if (node.kind == YamlNode::Kind::kMap && creates && has_definitions(before_))
      return report_definition(node, step, start, end);
    if (node.kind == YamlNode::Kind::kMap && creates) {
      node.entries.push_back({step, mark, {.mark = mark}});
      return &node.entries.back().value;
    }
    return report(node, step, start, end);
  }

  static bool is_index(const std::string& step) {
    return step.find_first_not_of("0123456789") == std::string::npos;
  }

  YamlNode* report_missing_list(const std::string& step, std::size_t start, std::size_t end) {
    return fail(start, end,
                fmt::format("the file has no list '{}', of which '{}' would be an index",
                            joined(before_), step),
                fmt::format("set '{}' as a whole, or write it into the file", joined(before_)));
  }

  YamlNode* report_definition(const YamlNode& map, const std::string& step, std::size_t start,
                              std::size_t end) {
    const std::vector<std::string> names = names_at(map);
    return fail(start, end,
                fmt::format("the file has no '{}': there is no '{}' in '{}'",
                            key_.value.substr(0, end), step, joined(before_)),
                names.empty() ? "a path changes what the file defines"
                              : name_hint(step, names, "names there"),
                names);
  }

  YamlNode* report(const YamlNode& node, const std::string& step, std::size_t start,
                   std::size_t end) {
    const std::vector<std::string> names = names_at(node);
    if (missing_ == Missing::kValue)
      return fail(start, end,
                  fmt::format("the file has no '{}': there is no '{}'", key_.value, step),
                  node.kind == YamlNode::Kind::kMap ? name_hint(step, names, "keys there")
                                                    : fmt::format("there is {}", kind_name(node)),
                  names);
    if (node.kind != YamlNode::Kind::kSequence)
      return fail(start, end,
                  fmt::format("'{}' leads into {}, which has no parts", key_.value.substr(0, end),
                              kind_name(node)));
    if (names.empty())
      return fail(start, end,
                  fmt::format("'{}' is not an index into a list of {}", step, node.items.size()),
                  "indices start at 0");
    return fail(
        start, end,
        fmt::format("'{}' is neither a name nor an index in a list of {}", step, node.items.size()),
        name_hint(step, names, "names") + "; indices start at 0", names);
  }

  const Name& key_;
  const Missing missing_;
  Diagnostics& out_;
  Steps before_;
};

YamlNode* find_entry(YamlNode& map, std::string_view key) {
  for (YamlNode::Entry& entry : map.entries)
    if (entry.key == key) return &entry.value;
  return nullptr;
}

/// The index that a step denotes; empty if the step is not an index.
std::optional<std::size_t> index_of(std::string_view step) {
  std::size_t index = 0;
  const char* end = step.data() + step.size();
  const auto [stop, code] = std::from_chars(step.data(), end, index);
  if (code != std::errc() || stop != end) return std::nullopt;
  return index;
}

/// Finds an item by index or name.
YamlNode* find_item(YamlNode& list, std::string_view step) {
  const auto index = index_of(step);
  if (index && *index < list.items.size()) return &list.items[*index];
  for (YamlNode& item : list.items)
    if (const std::string* name = name_of(item); name != nullptr && *name == step) return &item;
  return nullptr;
}

}  // namespace

YamlNode* find_part(YamlNode& node, std::string_view step) {
  if (node.kind == YamlNode::Kind::kMap) return find_entry(node, step);
  if (node.kind != YamlNode::Kind::kSequence) return nullptr;
  return find_item(node, step);
}

YamlNode* find_node(YamlNode& root, const Name& key, Missing missing, Diagnostics& out) {
  return Walk(key, missing, out).from(root);
}

YamlNode* find_present(YamlNode& root, std::string_view key) {
  YamlNode* node = &root;
  while (node != nullptr && !key.empty()) {
    const std::size_t length = step_length(*node, key);
    node = find_part(*node, key.substr(0, length));
    key.remove_prefix(std::min(length + 1, key.size()));
  }
  return node;
}

std::string_view first_step(std::string_view key) { return key.substr(0, key.find('.')); }

}  // namespace conddp
