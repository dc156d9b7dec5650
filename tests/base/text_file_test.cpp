#include "base/files/text_file.hpp"

#include <fstream>

#include <gtest/gtest.h>

#include "base/files/check_sums.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

class ReadText : public testing::Test {
 protected:
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
  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
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

TEST_F(ReadText, ReportsErrorsOfAFile) {
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
