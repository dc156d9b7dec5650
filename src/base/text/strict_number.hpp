#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace conddp {

/// A strictly parsed number, or the reason for rejecting it.
struct ParsedNumber {
  std::optional<double> value;
  std::string defect;  ///< a clause: "'1e999' is out of range"
};

/// Parses finite decimal notation in the range of double. Rejects hexadecimal and octal forms,
/// leading zeros (YAML 1.1 would read 010 as 8), inf, nan, and trailing characters.
ParsedNumber parse_number(std::string_view text);

/// Parses a whole number that consists of digits and fits an int; otherwise returns nothing.
std::optional<int> parse_count(std::string_view text);

}  // namespace conddp
