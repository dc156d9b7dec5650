#include "base/json/json_document.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace conddp {
namespace {

constexpr std::string_view kKeys[] = {"t"};

std::optional<nlohmann::json> parse(const std::string& text, Diagnostics& out) {
  return parse_document(text, "answer.json", kSolutionDocument, kKeys, out);
}

TEST(JsonDocument, KeepsWantedMembersAlone) {
  Diagnostics out;
  const auto document = parse(R"( {"gains": [[1, {"t": "]}"}], "\"}"], "t" : [1, [2]],
      "format": "conddp.solution/1", "text": "a\\", "empty": {}, "number": -1e3} )",
                              out);
  ASSERT_TRUE(document) << format_diagnostics(out, false);
  EXPECT_EQ(*document, nlohmann::json::parse(R"({"format": "conddp.solution/1", "t": [1, [2]]})"));
}

TEST(JsonDocument, ErrorsHaveTheirPlaceInTheFile) {
  Diagnostics out;
  EXPECT_FALSE(
      parse("{\"gains\": [1, 2],\n \"format\": \"conddp.solution/1\",\n \"t\": [1,,]}", out));
  ASSERT_EQ(out.error_count(), 1);
  EXPECT_EQ(out.list().front().line, 3);
  EXPECT_EQ(out.list().front().column, 10);
}

TEST(JsonDocument, RefusesDamagedText) {
  for (const char* text :
       {"", "{", "[]", "{\"t\": 1", "{\"t\": [1}", "{\"t\": 1} x", "{\"t\": \"", "{t: 1}",
        "{\"t\" 1}", "{\"gains\": [1, 2}, \"t\": 1}", "{\"gains\": \"\\", "{\"t\": 1,}",
        "{\"format\": \"conddp.solution/1\", \"t\": 1, \"t\": 2}",
        "{\"format\": \"conddp.solution/2\", \"t\": 1}"}) {
    Diagnostics out;
    EXPECT_FALSE(parse(text, out)) << text;
    EXPECT_GT(out.error_count(), 0) << text;
  }
}

}  // namespace
}  // namespace conddp
