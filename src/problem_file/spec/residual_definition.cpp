#include "problem_file/spec/residual_definition.hpp"

#include <algorithm>

namespace conddp {

bool ResidualDefinition::has(std::string_view key) const {
  return std::any_of(keys.begin(), keys.end(),
                     [&](const ResidualKey* own) { return own->name == key; });
}

}  // namespace conddp
