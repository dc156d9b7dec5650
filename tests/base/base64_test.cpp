#include "base/text/base64.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

// Vectors of RFC 4648, section 10.
TEST(Base64, GivesThePublishedTexts) {
  EXPECT_EQ(base64(""), "");
  EXPECT_EQ(base64("f"), "Zg==");
  EXPECT_EQ(base64("fo"), "Zm8=");
  EXPECT_EQ(base64("foo"), "Zm9v");
  EXPECT_EQ(base64("foob"), "Zm9vYg==");
  EXPECT_EQ(base64("fooba"), "Zm9vYmE=");
  EXPECT_EQ(base64("foobar"), "Zm9vYmFy");
}

TEST(Base64, HighBytesAreUnsigned) { EXPECT_EQ(base64("\xff\xfe\xbf"), "//6/"); }

TEST(Base64, GivesBackAllBytes) {
  std::string bytes;
  for (int i = 0; i < 256; ++i) {
    EXPECT_EQ(bytes_of_base64(base64(bytes)), bytes);
    bytes += static_cast<char>(i * 7);
  }
}

TEST(Base64, ReadsTextsWithoutPadding) {
  EXPECT_EQ(bytes_of_base64("Zg"), "f");
  EXPECT_EQ(bytes_of_base64("Zm8"), "fo");
}

TEST(Base64, OtherTextsHaveNoBytes) {
  for (const char* text :
       {"Z", "Zg=", "Zg===", "=", "Zm9vY", "Zm 9", "Zm9*", "Z=9v", "\xff\xff\xff\xff"})
    EXPECT_EQ(bytes_of_base64(text), std::nullopt) << text;
}

}  // namespace
}  // namespace conddp
