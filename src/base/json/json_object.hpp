#pragma once

#include <cstddef>
#include <utility>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// An empty object with capacity for `entries` members. Growing beyond the capacity copies all
/// contents, for a large document more than once.
inline OrderedJson json_object(std::size_t entries) {
  OrderedJson::object_t object;
  object.reserve(entries);
  return OrderedJson(std::move(object));
}

}  // namespace conddp
