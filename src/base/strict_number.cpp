#include "base/strict_number.hpp"

#include <cctype>
#include <charconv>
#include <cmath>

#include <fmt/format.h>

namespace conddp {

ParsedNumber parse_number(std::string_view text) {
  const auto defect = [&](std::string_view why) {
    constexpr std::size_t kShown = 40;
    return ParsedNumber{
        {},
        fmt::format("'{}{}' {}", text.substr(0, kShown), text.size() > kShown ? "..." : "", why)};
  };
  std::string_view digits = text;
  if (digits.starts_with('+') || digits.starts_with('-')) digits.remove_prefix(1);
  const auto is_digit = [](char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; };
  if (digits == ".inf" || digits == ".Inf" || digits == ".INF" || digits == ".nan" ||
      digits == ".NaN" || digits == ".NAN" || digits == "inf" || digits == "nan")
    return defect("is not finite");
  if (digits.empty() || !(is_digit(digits[0]) || digits[0] == '.'))
    return defect("is not a number");
  if (digits.size() > 1 && digits[0] == '0' && is_digit(digits[1]))
    return defect("has a leading zero");
  const std::string_view whole = text.starts_with('+') ? digits : text;
  double value = 0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value);
  if (error == std::errc::result_out_of_range) return defect("is out of range");
  if (error != std::errc() || end != whole.data() + whole.size()) return defect("is not a number");
  if (!std::isfinite(value)) return defect("is not finite");
  return {value, {}};
}

}  // namespace conddp
