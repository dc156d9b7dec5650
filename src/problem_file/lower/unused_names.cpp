#include "problem_file/lower/unused_names.hpp"

#include <optional>
#include <set>
#include <string>
#include <string_view>

#include <fmt/format.h>

#include "problem_file/yaml/path_step.hpp"
#include "systems/expressions/lexer.hpp"

namespace conddp {
namespace {

/// Keys under which names are defined. Such names count as used if they occur as values elsewhere.
bool defines_names(std::string_view key) {
  return key == "parameters" || key == "tables" || key == "let" || key == "of" || key == "systems";
}

/// The words of a document's values and of its keys, except keys that define names.
class UsedWords {
 public:
  explicit UsedWords(const YamlNode& root) {
    for (const YamlNode::Entry& entry : root.entries)
      if (entry.key != "name" && entry.key != "description") add(entry.value, entry.key);
  }
  bool has(const std::string& name) const { return words_.contains(name); }

 private:
  void add(const YamlNode& node, std::string_view key) {
    add_words(node.text);
    for (const YamlNode& item : node.items) add(item, "");
    for (const YamlNode::Entry& entry : node.entries) {
      if (!defines_names(key)) add_words(entry.key);
      add(entry.value, entry.key);
    }
  }
  void add_words(std::string_view text) {
    std::size_t end = 0;
    for (std::size_t at = 0; at < text.size(); at = end + 1) {
      for (end = at; end < text.size() && is_name_part(text[end]);) ++end;
      if (end > at) words_.insert(std::string(text.substr(at, end - at)));
    }
  }

  std::set<std::string> words_;
};

class UnusedNames {
 public:
  UnusedNames(const YamlNode& root, Diagnostics& out) : root_(root), out_(out) {
    for (const YamlNode::Entry& entry : root.entries) {
      if (entry.key == "parameters") look_at_free(entry.value);
      if (entry.key == "systems") look_at_systems(entry.value, root.find("phases"));
    }
    look_at(root);
  }

 private:
  /// Builds the list of words on demand: most documents define no names.
  bool is_used(const std::string& name) {
    if (!used_) used_.emplace(root_);
    return used_->has(name);
  }

  void look_at_free(const YamlNode& parameters) {
    for (const YamlNode::Entry& entry : parameters.entries)
      if (entry.value.kind == YamlNode::Kind::kMap && !is_used(entry.key))
        out_.warning(
            {entry.mark, "parameters." + entry.key},
            fmt::format("'{}' is free, and occurs in no equation, residual or payload", entry.key));
  }

  void look_at_systems(const YamlNode& systems, const YamlNode* phases) {
    std::set<std::string> named;
    if (phases != nullptr)
      for (const YamlNode& phase : phases->items)
        if (const YamlNode* system = phase.find("system")) named.insert(system->text);
    for (const YamlNode::Entry& entry : systems.entries)
      if (!named.contains(entry.key))
        out_.warning({entry.mark, "systems." + entry.key},
                     fmt::format("no phase has the system '{}'", entry.key));
  }

  /// Checks tables, definitions and named residuals in a node and below.
  void look_at(const YamlNode& node) {
    for (std::size_t i = 0; i < node.items.size(); ++i) {
      const PathStep step(path_, i);
      look_at(node.items[i]);
    }
    for (const YamlNode::Entry& entry : node.entries) {
      const PathStep step(path_, entry.key);
      if (entry.key == "tables" || entry.key == "let" || entry.key == "of")
        look_at_definitions(entry.value);
      look_at(entry.value);
    }
  }

  void look_at_definitions(const YamlNode& definitions) {
    for (const YamlNode::Entry& entry : definitions.entries)
      if (!is_used(entry.key))
        out_.warning({entry.mark, path_ + "." + entry.key},
                     fmt::format("nothing uses '{}'", entry.key));
  }

  const YamlNode& root_;
  std::optional<UsedWords> used_;
  std::string path_;  ///< path of the current node
  Diagnostics& out_;
};

}  // namespace

void warn_of_unused_names(const YamlNode& root, Diagnostics& out) { UnusedNames(root, out); }

}  // namespace conddp
