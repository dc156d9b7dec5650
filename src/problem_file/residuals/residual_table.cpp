#include "problem_file/residuals/residual_table.hpp"

#include <algorithm>

namespace conddp {

const std::vector<const ResidualDefinition*>& residual_table() {
  static const std::vector<const ResidualDefinition*> table = [] {
    std::vector<const ResidualDefinition*> all;
    for (const auto family : kResidualFamilies)
      for (const ResidualDefinition& definition : family()) all.push_back(&definition);
    return all;
  }();
  return table;
}

const ResidualDefinition* find_residual(std::string_view name) {
  const auto& table = residual_table();
  const auto found =
      std::find_if(table.begin(), table.end(), [&](const auto* d) { return d->name == name; });
  return found == table.end() ? nullptr : *found;
}

const std::vector<const ResidualKey*>& residual_keys() {
  static const std::vector<const ResidualKey*> keys = [] {
    std::vector<const ResidualKey*> all;
    for (const ResidualDefinition* definition : residual_table())
      for (const ResidualKey* key : definition->keys)
        if (std::find(all.begin(), all.end(), key) == all.end()) all.push_back(key);
    return all;
  }();
  return keys;
}

}  // namespace conddp
