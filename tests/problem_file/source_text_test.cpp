#include "problem_file/source_text.hpp"

#include <fstream>

#include <unistd.h>

#include <gtest/gtest.h>

#include "problem_file/sha256.hpp"

namespace conddp {
namespace {

TEST(SourceText, FindsBadCharacters) {
  EXPECT_EQ(find_bad_character("plain\ttext\r\nwith ünïcode ∂ 𝛼"), std::string::npos);
  EXPECT_EQ(find_bad_character("ab\x01"), 2u);
  EXPECT_EQ(find_bad_character(std::string_view("a\0b", 3)), 1u);
  EXPECT_EQ(find_bad_character("a\x7F"), 1u);
  EXPECT_EQ(find_bad_character("\xC3\x28"), 0u);          // a broken pair
  EXPECT_EQ(find_bad_character("\xC0\xAF"), 0u);          // overlong
  EXPECT_EQ(find_bad_character("x\xED\xA0\x80"), 1u);     // a surrogate
  EXPECT_EQ(find_bad_character("\xF5\x80\x80\x80"), 0u);  // beyond Unicode
  EXPECT_EQ(find_bad_character("\xE2\x82"), 0u);          // cut off
}

class ReadText : public testing::Test {
 protected:
  ReadText() {
    char name[] = "/tmp/conddp_text_XXXXXX";
    folder_ = mkdtemp(name);
  }
  ~ReadText() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path write(const std::string& text) {
    std::ofstream(folder_ / "file", std::ios::binary) << text;
    return folder_ / "file";
  }
  std::string error(const std::filesystem::path& file, std::size_t limit = 1000) {
    Diagnostics out;
    EXPECT_FALSE(read_text(file, limit, {}, hash_, out));
    if (out.list().size() != 1) return "";
    const Diagnostic& d = out.list().front();
    return std::to_string(d.line) + ":" + std::to_string(d.column) + ": " + d.message;
  }
  std::filesystem::path folder_;
  std::string hash_;
};

TEST_F(ReadText, DropsAByteOrderMark) {
  Diagnostics out;
  EXPECT_EQ(read_text(write("\xEF\xBB\xBF"
                            "a: 1\n"),
                      100, {}, hash_, out),
            "a: 1\n");
  EXPECT_EQ(hash_, sha256("\xEF\xBB\xBF"
                          "a: 1\n"));
}

TEST_F(ReadText, SaysWhatIsWrongWithAFile) {
  EXPECT_NE(error(folder_ / "absent").find("does not exist"), std::string::npos);
  EXPECT_NE(error(folder_).find("is a folder"), std::string::npos);
  EXPECT_NE(error("/dev/zero").find("not a regular file"), std::string::npos);
  EXPECT_NE(error(write(std::string(2 << 20, 'x')), 1 << 20).find("larger than 1 MiB"),
            std::string::npos);
}

TEST_F(ReadText, NamesThePlaceOfABadCharacter) {
  EXPECT_EQ(error(write("ok\nän\xFFx\n")), "2:3: the text is not UTF-8 (byte 0xFF)");
  EXPECT_EQ(error(write("a\x02")), "1:2: a control character (0x02) in the text");
}

}  // namespace
}  // namespace conddp
