#include "output/bench/junit.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(Junit, CountsAndEscapes) {
  const std::string xml =
      junit_xml("a & b", {{.name = "good", .time_s = 0.5},
                          {.name = "bad", .time_s = 0.25, .failures = {"1 < \"2\"", "second"}},
                          {.name = "odd\x01", .error = "two\nlines"}});
  EXPECT_EQ(xml,
            "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
            "<testsuite name=\"a &amp; b\" tests=\"3\" failures=\"1\" errors=\"1\" "
            "time=\"0.750000\">\n"
            "  <testcase classname=\"a &amp; b\" name=\"good\" time=\"0.500000\"/>\n"
            "  <testcase classname=\"a &amp; b\" name=\"bad\" time=\"0.250000\">\n"
            "    <failure message=\"1 &lt; &quot;2&quot;\">1 &lt; &quot;2&quot;\nsecond\n"
            "</failure>\n"
            "  </testcase>\n"
            "  <testcase classname=\"a &amp; b\" name=\"odd?\" time=\"0.000000\">\n"
            "    <error message=\"two&#10;lines\"/>\n"
            "  </testcase>\n"
            "</testsuite>\n");
}

}  // namespace
}  // namespace conddp
