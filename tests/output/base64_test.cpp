#include "output/scene/base64.hpp"

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

}  // namespace
}  // namespace conddp
