#pragma once

#include <cmath>

#include <nlohmann/json.hpp>

namespace conddp {

/// JSON that keeps the insertion order of keys.
using OrderedJson = nlohmann::ordered_json;

/// The number, or null if it is not finite, which JSON cannot represent.
inline OrderedJson finite_or_null(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

}  // namespace conddp
