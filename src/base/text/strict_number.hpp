#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace conddp {

/// A number read strictly, or why it is none.
struct ParsedNumber {
  std::optional<double> value;
  std::string defect;  ///< a clause: "'1e999' is out of range"
};

/// Decimal notation alone, finite, in the range of double: no hexadecimal or octal forms, no
/// leading zeros (YAML 1.1 would read 010 as 8), no inf or nan, nothing behind the number.
ParsedNumber parse_number(std::string_view text);

/// A whole number of digits alone that fits an int; nothing else.
std::optional<int> parse_count(std::string_view text);

}  // namespace conddp
