#include "problem_file/read/settled_settings.hpp"

#include <algorithm>

#include "problem_file/lower/parameter_values.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {
namespace {

bool has_formula(const YamlNode& node) {
  return (node.kind == YamlNode::Kind::kScalar && node.text.starts_with('=')) ||
         std::any_of(node.items.begin(), node.items.end(), has_formula) ||
         std::any_of(node.entries.begin(), node.entries.end(),
                     [](const YamlNode::Entry& entry) { return has_formula(entry.value); });
}

}  // namespace

std::vector<Setting> settled_settings(const ProblemDocument& document,
                                      const std::vector<Setting>& settings) {
  std::vector<Setting> settled = settings;
  if (std::none_of(settings.begin(), settings.end(),
                   [](const Setting& setting) { return has_formula(setting.value); }))
    return settled;
  YamlNode root = document.root;
  Diagnostics out;
  for (const Setting& setting : settings) apply_setting(root, setting, out);
  if (!out.has_errors()) place_parameters(root, out);
  if (out.has_errors()) return settings;
  for (Setting& setting : settled)
    if (const YamlNode* value = find_present(root, setting.key.value)) setting.value = *value;
  return settled;
}

}  // namespace conddp
