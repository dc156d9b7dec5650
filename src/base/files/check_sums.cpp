#include "base/files/check_sums.hpp"

#include <algorithm>
#include <cstring>

#include <sha2.h>

#include <fmt/format.h>

namespace conddp {
namespace {

constexpr std::size_t kSumDigits = 8;
constexpr std::string_view kStart = R"({"sum":")", kEnd = R"(",)";

std::string sum_of(std::string_view text) { return sha256(text).substr(0, kSumDigits); }

}  // namespace

std::string sha256(std::string_view bytes) {
  char text[SHA256_DIGEST_STRING_LENGTH];
  SHA256Data(reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size(), text);
  return text;
}

std::uint64_t check_sum(std::string_view bytes) {
  constexpr std::uint64_t kFactor = 0x9fb21c651e98df25;
  std::uint64_t sum = 0x9e3779b97f4a7c15 ^ bytes.size();
  while (!bytes.empty()) {
    std::uint64_t word = 0;
    const std::size_t length = std::min(sizeof word, bytes.size());
    std::memcpy(&word, bytes.data(), length);
    bytes.remove_prefix(length);
    sum = (sum ^ word) * kFactor;
    sum ^= sum >> 32;
  }
  return sum;
}

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
