#include "base/text/utf8.hpp"

#include <string>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(Utf8, FindsBadCharacters) {
  EXPECT_EQ(find_bad_character("plain\ttext\r\nwith ünïcode ∂ 𝛼"), std::string::npos);
  EXPECT_EQ(find_bad_character("ab\x01"), 2u);
  EXPECT_EQ(find_bad_character(std::string_view("a\0b", 3)), 1u);
  EXPECT_EQ(find_bad_character("a\x7F"), 1u);
  EXPECT_EQ(find_bad_character("\xC3\x28"), 0u);          // a broken pair
  EXPECT_EQ(find_bad_character("\xC0\xAF"), 0u);          // overlong
  EXPECT_EQ(find_bad_character("x\xED\xA0\x80"), 1u);     // a surrogate
  EXPECT_EQ(find_bad_character("\xF5\x80\x80\x80"), 0u);  // beyond Unicode
  EXPECT_EQ(find_bad_character("\xE2\x82"), 0u);          // truncated
  EXPECT_EQ(find_bad_character("ab\xE9"), 2u);            // Latin-1
}

TEST(Utf8, DescribesBadCharacters) {
  EXPECT_EQ(describe_bad_character("\xE9", 0), "the text is not UTF-8 (byte 0xE9)");
  EXPECT_EQ(describe_bad_character("a\x1B", 1), "a control character (0x1B) in the text");
}

TEST(Utf8, ShowsAnyBytesOnOneLine) {
  EXPECT_EQ(printable("größe 𝛼"), "größe 𝛼");
  EXPECT_EQ(printable("a\nb\tc\r"), "a\\nb\\tc\\r");
  EXPECT_EQ(printable("\x1B[31m"), "\\x1B[31m");
  EXPECT_EQ(printable(std::string_view("\0\x7F", 2)), "\\x00\\x7F");
  EXPECT_EQ(printable("\xC3(\xE9"), "\\xC3(\\xE9");
}

// C1 controls, separators, and directional marks; terminals obey some of them.
const std::string kCommands[] = {"\u0080", "\u009B", "\u2028", "\u2029",
                                 "\u202E", "\u2066", "\u200F", "\u061C"};

TEST(Utf8, HidesCommandsFromATerminal) {
  EXPECT_EQ(printable("a\u009B31m\u202Eb"), "a\\u009B31m\\u202Eb");
  for (const std::string& command : kCommands) {
    EXPECT_EQ(printable(command).substr(0, 2), "\\u");
    EXPECT_EQ(terminal_text(command), printable(command));
    EXPECT_EQ(masked("a" + command + "b"), "a?b");
  }
  for (const char* plain : {"größe 𝛼", "\u00A0", "\u2027", "\u2030", "\u2065", "日本"})
    for (const std::string& shown : {printable(plain), terminal_text(plain), masked(plain)})
      EXPECT_EQ(shown, plain);
}

TEST(Utf8, TerminalLinesKeepEndingsAndEscapeLikeJson) {
  EXPECT_EQ(terminal_text("a\n\tb"), "a\n\tb");
  EXPECT_EQ(terminal_text("\x1B[31m\r\x7F\xE9"), "\\u001B[31m\\u000D\\u007F\\xE9");
  EXPECT_EQ(masked("a\x1B\xE9"), "a??");
}

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
