#pragma once

#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// JSON for people: objects and lists of lists are indented; lists of numbers and flat objects in
/// lists are on one line. Numbers are the shortest that round-trip; null if not finite.
std::string json_text(const OrderedJson& value);

/// The same JSON on one line, without blanks and line end. Bytes that are not UTF-8 become U+FFFD.
std::string compact_json(const OrderedJson& value);

/// A number for display, rounded to eight digits: more than a screen shows, half of a double's.
/// Null if it is not finite.
OrderedJson eight_digits(double value);

}  // namespace conddp
