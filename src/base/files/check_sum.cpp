#include "base/files/check_sum.hpp"

#include <algorithm>
#include <cstring>

namespace conddp {

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

}  // namespace conddp
