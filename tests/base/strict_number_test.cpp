#include "base/text/strict_number.hpp"

#include <limits>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(StrictNumber, ReadsDecimalNotation) {
  EXPECT_EQ(parse_number("0").value, 0.0);
  EXPECT_EQ(parse_number("-1.5e-3").value, -1.5e-3);
  EXPECT_EQ(parse_number("+2").value, 2.0);
  EXPECT_EQ(parse_number(".5").value, 0.5);
  EXPECT_EQ(parse_number("0.1").value, 0.1);
  EXPECT_EQ(parse_number("1.7976931348623157e308").value, std::numeric_limits<double>::max());
}

TEST(StrictNumber, RejectsWhatYamlLibrariesAccept) {
  for (const char* text : {"",       "-",    "+",     "abc",  "0x10", "010", "-010",     "1e400",
                           "1e-400", ".inf", "-.inf", ".nan", "inf",  "nan", "infinity", "1_000",
                           "1,5",    "1.5x", "1 2",   "--1",  "+-1",  " 1"})
    EXPECT_FALSE(parse_number(text).value) << "'" << text << "'";
}

TEST(StrictNumber, ExplainsRejections) {
  EXPECT_EQ(parse_number("010").defect, "'010' has a leading zero");
  EXPECT_EQ(parse_number("1e999").defect, "'1e999' is out of range");
  EXPECT_EQ(parse_number(".inf").defect, "'.inf' is not finite");
  EXPECT_EQ(parse_number("x").defect, "'x' is not a number");
}

TEST(ParseCount, AcceptsOnlyDigitsThatFitAnInt) {
  EXPECT_EQ(parse_count("0"), 0);
  EXPECT_EQ(parse_count("1001"), 1001);
  EXPECT_EQ(parse_count("2147483647"), 2147483647);
  for (const char* text : {"", "-0", "-1", "+1", " 1", "1 ", "1x", "x", "1.0", "2147483648"})
    EXPECT_FALSE(parse_count(text)) << text;
}

}  // namespace
}  // namespace conddp
