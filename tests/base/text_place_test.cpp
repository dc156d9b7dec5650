#include "base/text/text_place.hpp"

#include <string>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(TextPlace, CountsLinesAndCharacters) {
  const auto place = [](TextPlace at) {
    return std::to_string(at.line) + ":" + std::to_string(at.column);
  };
  EXPECT_EQ(place(place_after("")), "1:1");
  EXPECT_EQ(place(place_after("aé∂")), "1:4");
  EXPECT_EQ(place(place_after("a\nbc\n")), "3:1");
  EXPECT_EQ(place(place_after("é", {4, 7})), "4:8");
  EXPECT_EQ(place(place_after("a\né", {4, 7})), "5:2");
}

}  // namespace
}  // namespace conddp
