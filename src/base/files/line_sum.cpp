#include "base/files/line_sum.hpp"

#include <fmt/format.h>

#include "base/files/sha256.hpp"

namespace conddp {
namespace {

constexpr std::size_t kSumDigits = 8;
constexpr std::string_view kStart = R"({"sum":")", kEnd = R"(",)";

std::string sum_of(std::string_view text) { return sha256(text).substr(0, kSumDigits); }

}  // namespace

std::string with_sum(std::string_view line) {
  return fmt::format("{}{}{}{}", kStart, sum_of(line), kEnd, line.substr(1));
}

bool has_sum(std::string_view line) { return line.starts_with(kStart); }

std::string without_sum(std::string_view line) {
  if (!has_sum(line) || line.size() < kStart.size() + kSumDigits + kEnd.size()) return {};
  const std::string_view sum = line.substr(kStart.size(), kSumDigits);
  std::string rest = "{";
  rest += line.substr(kStart.size() + kSumDigits + kEnd.size());
  return sum_of(rest) == sum ? rest : std::string();
}

}  // namespace conddp
