#pragma once

#include <cmath>

#include <nlohmann/json.hpp>

namespace conddp {

/// JSON whose keys keep the order in which they were put in.
using OrderedJson = nlohmann::ordered_json;

/// The number, or null for what JSON has no number for.
inline OrderedJson finite_or_null(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

}  // namespace conddp
