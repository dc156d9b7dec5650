#include "base/text/text_layout.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(WrapText, BreaksAtSpaces) {
  EXPECT_EQ(wrap_text("one two three", 7, 0, 2), "one two\n  three\n");
  EXPECT_EQ(wrap_text("one two three", 8, 2, 4), "  one\n    two\n    three\n");
  EXPECT_EQ(wrap_text("one two three", 0, 1, 4), " one two three\n");
}

TEST(WrapText, LongWordsHaveTheirOwnLine) {
  EXPECT_EQ(wrap_text("a abcdefghij b", 5, 0, 0), "a\nabcdefghij\nb\n");
}

TEST(WrapText, KeepsLineEndsAndEmptyLines) {
  EXPECT_EQ(wrap_text("a\n\nb c", 10, 0, 2), "a\n\n  b c\n");
  EXPECT_EQ(wrap_text("", 10, 0, 0), "\n");
}

TEST(WrapText, CountsCharactersWithoutColors) {
  EXPECT_EQ(shown_width("½ Σ"), 3);
  EXPECT_EQ(shown_width("\033[1;31merror\033[0m:"), 6);
  EXPECT_EQ(wrap_text("½½½ ½½½", 7, 0, 0), "½½½ ½½½\n");
}

}  // namespace
}  // namespace conddp
