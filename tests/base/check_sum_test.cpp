#include "base/files/check_sum.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(CheckSum, ChangesWithEveryByteAndWithTheLength) {
  const std::string text = "nineteen characters";
  std::vector<std::uint64_t> sums = {check_sum(text), check_sum(text + '\0'), check_sum("")};
  for (std::size_t i = 0; i < text.size(); ++i) {
    std::string changed = text;
    changed[i] ^= 1;
    sums.push_back(check_sum(changed));
  }
  std::sort(sums.begin(), sums.end());
  EXPECT_EQ(std::adjacent_find(sums.begin(), sums.end()), sums.end());
}

}  // namespace
}  // namespace conddp
