#pragma once

#include <cmath>
#include <cstddef>
#include <string>
#include <utility>

#include <nlohmann/json.hpp>

namespace conddp {

/// JSON that keeps the insertion order of keys.
using OrderedJson = nlohmann::ordered_json;

/// The number, or null if it is not finite, which JSON cannot represent.
inline OrderedJson finite_or_null(double value) {
  return std::isfinite(value) ? OrderedJson(value) : OrderedJson(nullptr);
}

/// An empty object with capacity for `entries` members. Growing beyond the capacity copies all
/// contents, for a large document more than once.
inline OrderedJson json_object(std::size_t entries) {
  OrderedJson::object_t object;
  object.reserve(entries);
  return OrderedJson(std::move(object));
}

/// JSON for people: objects and lists of lists are indented; lists of numbers and flat objects in
/// lists are on one line. Numbers are the shortest that round-trip; null if not finite.
std::string json_text(const OrderedJson& value);

/// The same JSON on one line, without blanks and line end. Bytes that are not UTF-8 become U+FFFD.
std::string compact_json(const OrderedJson& value);

/// A number for display, rounded to eight digits: more than a screen shows, half of a double's.
/// Null if it is not finite.
OrderedJson eight_digits(double value);

}  // namespace conddp
