#include "base/text/strict_number.hpp"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <iterator>

#include <fmt/format.h>

namespace conddp {

namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

/// True for spellings of non-finite numbers in YAML and C.
bool is_not_finite(std::string_view digits) {
  constexpr std::string_view kWords[] = {".inf", ".Inf", ".INF", ".nan",
                                         ".NaN", ".NAN", "inf",  "nan"};
  return std::find(std::begin(kWords), std::end(kWords), digits) != std::end(kWords);
}

/// Why a text without its sign is not a number, judging by its first characters.
std::string_view defect_of_start(std::string_view digits) {
  if (is_not_finite(digits)) return "is not finite";
  if (digits.empty() || !(is_digit(digits[0]) || digits[0] == '.')) return "is not a number";
  if (digits.size() > 1 && digits[0] == '0' && is_digit(digits[1])) return "has a leading zero";
  return {};
}

}  // namespace

ParsedNumber parse_number(std::string_view text) {
  const auto defect = [&](std::string_view why) {
    constexpr std::size_t kShown = 40;
    return ParsedNumber{
        {},
        fmt::format("'{}{}' {}", text.substr(0, kShown), text.size() > kShown ? "..." : "", why)};
  };
  std::string_view digits = text;
  if (digits.starts_with('+') || digits.starts_with('-')) digits.remove_prefix(1);
  if (const auto why = defect_of_start(digits); !why.empty()) return defect(why);
  const std::string_view whole = text.starts_with('+') ? digits : text;
  double value = 0;
  const auto [end, error] = std::from_chars(whole.data(), whole.data() + whole.size(), value);
  if (error == std::errc::result_out_of_range) return defect("is out of range");
  if (error != std::errc() || end != whole.data() + whole.size()) return defect("is not a number");
  if (!std::isfinite(value)) return defect("is not finite");
  return {value, {}};
}

std::optional<int> parse_count(std::string_view text) {
  int value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size() || value < 0 || text[0] == '-')
    return std::nullopt;
  return value;
}

}  // namespace conddp
