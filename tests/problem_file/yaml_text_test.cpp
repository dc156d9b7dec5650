#include "problem_file/yaml/yaml_text.hpp"

#include "schema_document.hpp"
#include "yaml_1_1.hpp"

namespace conddp {
namespace {

using Words = std::vector<std::string>;

TEST(YamlText, Yaml11ReadersSeeItsNumbersAsNumbers) {
  const OrderedJson numbers = {1e-3,   -2e-8, 1e16,  5e-324, 1.7976931348623157e308,
                               1.5e-7, 0.1,   100.0, 0.0,    -1e300,
                               7,      -12,   1e15};
  const std::string text = yaml_text(numbers);
  EXPECT_EQ(Yaml11Reader::misread(text), Words());
  EXPECT_EQ(text.substr(0, 27), "[0.001, -2.0e-08, 1.0e+16, ");
  const YAML::Node back = YAML::Load(text);
  for (std::size_t i = 0; i < numbers.size(); ++i)
    EXPECT_EQ(back[i].as<double>(), numbers[i].get<double>());
}

TEST(YamlText, Yaml11ReadersSeeItsTextsAsTexts) {
  const OrderedJson texts = {"1e-3",       "1:30",  "010", "0x1f", "on", "No", "y",
                             "2026-01-02", "1_000", ".5",  "null", "~",  "<<", "="};
  const std::string text = yaml_text({{"y", texts}, {"off", 1}});
  EXPECT_EQ(Yaml11Reader::misread(text), Words());
  const YAML::Node back = YAML::Load(text)["y"];
  for (std::size_t i = 0; i < texts.size(); ++i) {
    EXPECT_EQ(back[i].Tag(), "!") << texts[i];  // quoted
    EXPECT_EQ(back[i].Scalar(), texts[i].get<std::string>());
  }
}

TEST(ReadyProblems, Yaml11ReadersReadThemAlike) {
  for (const auto& file : ready_problems())
    EXPECT_EQ(Yaml11Reader::misread(read_file(file)), Words()) << file;
  EXPECT_EQ(Yaml11Reader::misread("{a: 1e-3, b: 1.e5, c: 010, d: on, e: 1:30}"),
            (Words{"1e-3", "1.e5", "010", "on", "1:30"}));
}

}  // namespace
}  // namespace conddp
