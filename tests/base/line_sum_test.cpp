#include "base/files/line_sum.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(LineSum, IsRemovedIfItMatches) {
  const std::string line = R"({"id":"a","n":1})", summed = with_sum(line);
  EXPECT_TRUE(has_sum(summed));
  EXPECT_EQ(summed.substr(0, 8), R"({"sum":")");
  EXPECT_EQ(without_sum(summed), line);
}

TEST(LineSum, MatchesNoOtherLine) {
  std::string summed = with_sum(R"({"id":"a","n":1})");
  summed[summed.size() - 2] = '2';
  EXPECT_EQ(without_sum(summed), "");
  EXPECT_EQ(without_sum(R"({"id":"a"})"), "");
  EXPECT_EQ(without_sum(R"({"sum":"0)"), "");
  EXPECT_FALSE(has_sum(R"({"id":"a"})"));
}

}  // namespace
}  // namespace conddp
