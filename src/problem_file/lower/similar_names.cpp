#include "problem_file/lower/similar_names.hpp"

#include <algorithm>

#include "base/text/spelling.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

/// The names next to an entry that a setting created; empty if the document itself has the entry.
std::vector<std::string> names_beside(const std::string& path, const YamlNode& document,
                                      const std::vector<Setting>& settings) {
  const std::size_t dot = path.rfind('.');
  const auto leads_there = [&](const Setting& setting) {
    return setting.key.value.starts_with(path + '.');
  };
  std::vector<std::string> names;
  if (dot == std::string::npos || std::none_of(settings.begin(), settings.end(), leads_there))
    return names;
  YamlNode root = document;
  const YamlNode* map = find_present(root, path.substr(0, dot));
  if (map == nullptr || map->find(path.substr(dot + 1)) != nullptr) return names;
  for (const YamlNode::Entry& entry : map->entries) names.push_back(entry.key);
  return names;
}

/// Adds a hint to an error in an entry whose name may be wrong: similar names, or all names if the
/// error lacks a hint.
void add_names(const std::vector<std::string>& names, Diagnostic& said) {
  const std::string own = said.path.substr(said.path.rfind('.') + 1);
  if (!similar_names(own, names).empty() || (!names.empty() && said.hint.empty()))
    said.hint = name_hint(own, names, "names there");
}

}  // namespace

Diagnostics with_similar_names(const Diagnostics& after, const Diagnostics& before,
                               const YamlNode& document, const std::vector<Setting>& settings) {
  Diagnostics all = before;
  for (std::size_t i = before.list().size(); i < after.list().size(); ++i) {
    Diagnostic said = after.list()[i];
    if (said.severity == Severity::kError)
      add_names(names_beside(said.path, document, settings), said);
    all.add(std::move(said));
  }
  for (const InputFile& file : after.data_files()) all.add_data_file(file);
  return all;
}

}  // namespace conddp
