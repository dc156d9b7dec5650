#include "problem_file/document/similar_names.hpp"

#include <algorithm>

#include "base/text/spelling.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

/// The names beside an entry that a setting made; none where the document has the entry itself.
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

/// What helps where an entry is wrong, if its name may be: one that is alike, or any where nothing
/// else is known to help.
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
