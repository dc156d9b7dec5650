#include "base/text/diagnostic.hpp"

#include <sstream>

#include <gtest/gtest.h>

#include "base/text/text_layout.hpp"

namespace conddp {
namespace {

TEST(Diagnostics, PrintsLikeACompiler) {
  Diagnostics out;
  const int source = out.add_source("dir/file.yaml", "a: 1\nbé: [x]\n");
  out.error({{source, 2, out.character_column(source, 2, 6)}, "bé.0"}, "a number is expected",
            "leave it out");
  EXPECT_EQ(format_diagnostics(out, false),
            "dir/file.yaml:2:6: error: a number is expected\n"
            "  bé: [x]\n"
            "       ^\n"
            "  hint: leave it out\n");
}

TEST(Diagnostics, PrintsWithoutAPlace) {
  Diagnostics out;
  out.error({}, "nothing works");
  out.add({.file = "r.urdf", .severity = Severity::kNote, .message = "ignored"});
  EXPECT_EQ(format_diagnostics(out, false),
            "conddp: error: nothing works\nr.urdf: note: ignored\n");
  EXPECT_EQ(format_diagnostics(out, false, Severity::kWarning), "conddp: error: nothing works\n");
  EXPECT_TRUE(out.has_errors());
}

TEST(Diagnostics, ColorsOnRequest) {
  Diagnostics out;
  out.warning({}, "careful");
  EXPECT_EQ(format_diagnostics(out, false).find('\033'), std::string::npos);
  EXPECT_NE(format_diagnostics(out, true).find("\033[1;35mwarning"), std::string::npos);
  EXPECT_FALSE(out.has_errors());
}

TEST(Diagnostics, CutsLongLinesAroundThePlace) {
  Diagnostics out;
  const int source = out.add_source("f", std::string(5000, 'x') + "!" + std::string(5000, 'y'));
  out.error({{source, 1, 5001}, {}}, "here");
  const std::string text = format_diagnostics(out, false);
  EXPECT_LT(text.size(), 400u);
  const std::size_t line = text.find('\n') + 1;
  const std::size_t caret = text.find('^') - text.find('\n', line) - 1;
  EXPECT_EQ(text[line + caret], '!');
}

TEST(Diagnostics, CountsErrorsBeyondTheLimit) {
  Diagnostics out;
  for (int i = 0; i < 30; ++i) out.error({}, "wrong");
  const std::string text = format_diagnostics(out, false, Severity::kNote, 20);
  EXPECT_NE(text.find("10 more errors"), std::string::npos);
}

TEST(Diagnostics, LinesRespectTheWidth) {
  Diagnostics out;
  out.add_source("p.yaml", std::string(70, 'x') + " wrong " + std::string(70, 'y') + "\n");
  out.error({{0, 1, 72}, "a"}, "there is something wrong with this rather long line of the file",
            "take the long words out of it, all of them");
  const std::string text = format_diagnostics(out, true, Severity::kNote, 20, 40);
  EXPECT_NE(text.find("wrong"), std::string::npos);
  std::istringstream lines(text);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count)
    EXPECT_LE(shown_width(line), 40) << line;
  EXPECT_EQ(count, 7) << text;
}

}  // namespace
}  // namespace conddp
