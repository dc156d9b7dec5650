#pragma once

#include <string_view>
#include <vector>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// Documentation of a key of a closed-form system.
struct SystemKey {
  std::string_view name;
  std::string_view description;  ///< one line, with the unit
  OrderedJson schema;            ///< of its value: JSON Schema, with the default
  bool required = false;
};

/// The keys, except `type`, of each entry of kSystemTypes in its order.
std::vector<std::vector<SystemKey>> system_keys();

}  // namespace conddp
