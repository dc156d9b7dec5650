#pragma once

#include <cstddef>
#include <utility>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// An empty object with memory for so many entries. One that outgrows its memory copies all that it
/// holds: of a large document more than once.
inline OrderedJson json_object(std::size_t entries) {
  OrderedJson::object_t object;
  object.reserve(entries);
  return OrderedJson(std::move(object));
}

}  // namespace conddp
