#pragma once

#include <string>

#include "base/json/ordered_json.hpp"

namespace conddp {

/// JSON that a person can read: objects and lists of lists indented, lists of numbers and objects
/// without structure inside on one line. Numbers by shortest round trip, null for what is not
/// finite.
std::string json_text(const OrderedJson& value);

/// The same numbers on one line without blanks, without an end of line. Bytes that are no UTF-8
/// become U+FFFD.
std::string compact_json(const OrderedJson& value);

/// A number for the eye, rounded to eight digits: more than a screen shows, half of what a double
/// takes. Null for what is not finite.
OrderedJson eight_digits(double value);

}  // namespace conddp
