#include "problem_file/yaml/yaml_source.hpp"

#include <gtest/gtest.h>

namespace conddp {
namespace {

struct Case {
  const char* name;
  std::string text;
  int line;
  int column;
  const char* message;
};

class BadYaml : public testing::TestWithParam<Case> {};

TEST_P(BadYaml, IsRejectedAtItsPlace) {
  const Case& c = GetParam();
  Diagnostics out;
  const int source = out.add_source("file.yaml", c.text);
  EXPECT_FALSE(parse_yaml(c.text, source, out));
  ASSERT_EQ(out.list().size(), 1u) << format_diagnostics(out, false);
  const Diagnostic& d = out.list().front();
  EXPECT_EQ(d.file, "file.yaml");
  EXPECT_EQ(d.line, c.line);
  EXPECT_EQ(d.column, c.column);
  EXPECT_NE(d.message.find(c.message), std::string::npos) << d.message;
}

std::string nested(int levels) { return std::string(levels, '[') + std::string(levels, ']'); }

INSTANTIATE_TEST_SUITE_P(
    Classes, BadYaml,
    testing::Values(Case{"Empty", "", 1, 1, "nothing in the document"},
                    Case{"Comment", "# nothing\n", 1, 1, "nothing in the document"},
                    Case{"Comma", ",", 1, 1, "nothing in the document"},
                    Case{"NullRoot", "~", 1, 1, "nothing in the document"},
                    Case{"SecondDocument", "a: 1\n---\nb: 2\n", 3, 1, "follows the end"},
                    Case{"Rubbish", "[1]\n]\n", 2, 1, "not valid YAML"},
                    Case{"Anchor", "a: &x 1\n", 1, 4, "anchors"},
                    Case{"Alias", "a: 1\nb: *x\n", 2, 4, "aliases"},
                    Case{"SelfAlias", "a: &x [*x]\n", 1, 4, "anchors"},
                    Case{"MergeKey", "a: {b: 1}\nc:\n  <<: {b: 2}\n", 3, 3, "merge keys"},
                    Case{"Tag", "a: !!str 1\n", 1, 4, "tag"},
                    Case{"OwnTag", "a: !thing {b: 1}\n", 1, 4, "tag"},
                    Case{"Duplicate", "a: 1\nb: 2\na: 3\n", 3, 1, "'a' is given twice"},
                    Case{"DuplicateInside", "a: {b: 1, b: 2}\n", 1, 11, "'b' is given twice"},
                    Case{"ListAsKey", "[1, 2]: 3\n", 1, 1, "a key must be a name"},
                    Case{"Deep", nested(100), 1, 65, "deeper than 64"},
                    Case{"Deeper", nested(100000), 1, 65, "deeper than 64"},
                    Case{"Unclosed", "a: [1, 2\n", 2, 1, "not closed"},
                    Case{"UnclosedAtTheStart", "{a: 1", 1, 1, "this '{' is never closed"},
                    Case{"UnclosedQuote", "a: 'it''s\nb: 1\n", 1, 4, "never closed"},
                    Case{"UnclosedDoubleQuote", "ä: \"it\\\"\n", 1, 4, "never closed"},
                    Case{"ControlCharacter", "a: \"\\e[0m\"\n", 1, 4, "control character (0x1B)"},
                    Case{"LineEndInAKey", "\"a\\nb\": 1\n", 1, 1, "no line ends"},
                    Case{"Tab", "a:\n\tb: 1\n", 2, 3, "not valid YAML"},
                    Case{"Indentation", "a: 1\n  b: 2\n", 2, 4, "not valid YAML"},
                    Case{"Columns", "ä: [ö, &x 1]\n", 1, 8, "anchors"}),
    [](const auto& test) { return test.param.name; });

TEST(YamlSource, KeepsPlacesAndQuotes) {
  const std::string text = "a:\n  - 1\n  - 'x'\nb: {c: true}\n";
  Diagnostics out;
  const auto root = parse_yaml(text, out.add_source("f", text), out);
  ASSERT_TRUE(root);
  const YamlNode* a = root->find("a");
  ASSERT_TRUE(a);
  EXPECT_FALSE(a->items[0].quoted);
  EXPECT_TRUE(a->items[1].quoted);
  EXPECT_EQ(a->items[1].mark.line, 3);
  EXPECT_EQ(a->items[1].mark.column, 5);
  EXPECT_EQ(root->entries[1].mark.line, 4);
  EXPECT_EQ(root->find("b")->find("c")->text, "true");
}

TEST(YamlSource, SupportsJsonSurrogates) {
  const std::string text = R"({"a": "\ud83d\ude00 \\ud83d", "b": &x 1})";
  Diagnostics out;
  const auto root = parse_yaml(R"({"a": "\ud83d\ude00 \\ud83d"})", out.add_source("t", text), out);
  ASSERT_TRUE(root);
  EXPECT_EQ(root->find("a")->text, "\xF0\x9F\x98\x80 \\ud83d");
  EXPECT_FALSE(parse_yaml(text, out.add_source("t", text), out));
  ASSERT_TRUE(out.has_errors());
  EXPECT_EQ(out.list().back().column, static_cast<int>(text.find("&x")) + 1);
}

TEST(YamlSource, ManyKeysAreReadInReasonableTime) {
  std::string text = "{";
  for (int i = 0; i < 50000; ++i) text += "k" + std::to_string(i) + ": 1, ";
  text += "k1: 2}";
  Diagnostics out;
  EXPECT_FALSE(parse_yaml(text, out.add_source("f", text), out));
  EXPECT_NE(out.list().front().message.find("'k1' is given twice"), std::string::npos);
}

}  // namespace
}  // namespace conddp
