#include "base/json/ordered_json.hpp"

#include <bit>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace conddp {
namespace {

TEST(JsonText, NumbersMatchTheFormOfTheJsonLibrary) {
  for (const double value : {0.0,
                             -0.0,
                             1.0,
                             -2.5,
                             0.1,
                             0.001,
                             0.00012,
                             0.0001,
                             1e-5,
                             1.25e-5,
                             1e-9,
                             123456.0,
                             120.0,
                             1e14,
                             123456789012345.0,
                             1e15,
                             1.5e15,
                             1e16,
                             1e100,
                             5e-324,
                             std::numeric_limits<double>::max(),
                             std::numeric_limits<double>::min(),
                             std::nan(""),
                             std::numeric_limits<double>::infinity()})
    EXPECT_EQ(compact_json(OrderedJson(value)), OrderedJson(value).dump());
}

TEST(JsonText, NumbersOfAnySizeSurviveARoundTrip) {
  std::mt19937_64 engine(7);
  for (int i = 0; i < 20000; ++i) {
    const double value = std::bit_cast<double>(engine());
    if (!std::isfinite(value)) continue;
    const std::string text = compact_json(OrderedJson(value));
    EXPECT_EQ(OrderedJson::parse(text).get<double>(), value) << text;
    EXPECT_LE(text.size(), OrderedJson(value).dump().size()) << text;
  }
  for (int exponent = -8; exponent < 20; ++exponent) {
    const double value =
        std::pow(10.0, exponent) * std::uniform_real_distribution(1.0, 10.0)(engine);
    EXPECT_EQ(compact_json(OrderedJson(value)).find('e'), OrderedJson(value).dump().find('e'));
    EXPECT_EQ(OrderedJson::parse(compact_json(OrderedJson(value))).get<double>(), value);
  }
}

TEST(JsonText, CompactTextMatchesTheJsonLibrary) {
  const OrderedJson value = {{"whole", {1, -2, 18446744073709551615u}},
                             {"empty list", OrderedJson::array()},
                             {"empty object", OrderedJson::object()},
                             {"nested", {{{"a", nullptr}}, {{"b", {true, false}}}}},
                             {"quote \" and \\", "line\nend, tab\t, ü, \x7f"}};
  EXPECT_EQ(compact_json(value), value.dump());
}

TEST(JsonText, ReplacesInvalidUtf8OrReportsIt) {
  const OrderedJson value = "a\xff";
  EXPECT_EQ(compact_json(value), "\"a\xef\xbf\xbd\"");
  EXPECT_THROW(json_text(value), OrderedJson::type_error);
}

TEST(JsonText, TablesHaveARowOnEachLine) {
  const OrderedJson value = {{"list", {1, 2.5}},
                             {"rows", {{{"a", 1}, {"b", "x"}}, {{"a", 2}, {"b", {3}}}}},
                             {"matrix", {{1, 2}, {3, 4}}},
                             {"none", OrderedJson::array()}};
  EXPECT_EQ(json_text(value), R"({
  "list": [1,2.5],
  "rows": [
    {"a":1,"b":"x"},
    {
      "a": 2,
      "b": [3]
    }
  ],
  "matrix": [
    [1,2],
    [3,4]
  ],
  "none": []
}
)");
}

}  // namespace
}  // namespace conddp
