// Tool behavior on and off a terminal.
#include <regex>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "base/text/text_layout.hpp"
#include "long_problem.hpp"
#include "pseudo_terminal.hpp"

namespace conddp {
namespace {

std::vector<std::string> solve(const TemporaryFolder& folder) {
  return {"solve", kPendulum, "-o", folder.path() / "out"};
}

/// Wall-clock times differ from run to run.
std::string without_times(const std::string& text) {
  return std::regex_replace(text, std::regex(R"([0-9.]+ s\))"), "T s)");
}

/// Successive contents of the status line.
std::vector<std::string> drawings(const std::string& err) {
  std::vector<std::string> list;
  for (std::size_t at = err.find('\r'); at != err.npos;) {
    const std::size_t next = err.find('\r', at + 1);
    list.push_back(err.substr(at + 1, next == err.npos ? next : next - at - 1));
    at = next;
  }
  return list;
}

TEST(Terminal, OnlyTerminalsShowProgressWithEqualResults) {
  const TemporaryFolder folder;
  const std::vector<std::string> environment = {"TERM=xterm", "NO_COLOR=1"};
  const ProcessResult both = run_in_terminal(solve(folder), {.environment = environment});
  const ProcessResult pipe =
      run_in_terminal(solve(folder), {.environment = environment, .out = false, .err = false});
  EXPECT_EQ(both.exit_code, 0);
  EXPECT_EQ(pipe.exit_code, 0);
  EXPECT_EQ(pipe.err, "");
  EXPECT_NE(both.err.find(" s, iteration "), std::string::npos) << both.err;
  EXPECT_NE(both.err.find("stationarity"), std::string::npos) << both.err;
  EXPECT_NE(both.out, "");
  EXPECT_EQ(without_times(both.out), without_times(pipe.out));
  EXPECT_NE(without_times(pipe.out).find("iterations, T s)"), std::string::npos) << pipe.out;
}

TEST(Terminal, RedrawsAndErasesTheStatusLine) {
  const TemporaryFolder folder;
  const ProcessResult r = run_in_terminal(solve(folder), {.environment = {"TERM=xterm"}});
  EXPECT_EQ(r.err.find('\n'), std::string::npos);
  const std::vector<std::string> drawn = drawings(r.err);
  ASSERT_GE(drawn.size(), 3u);
  EXPECT_EQ(drawn.back(), "");
  const std::string& spaces = drawn[drawn.size() - 2];
  EXPECT_EQ(spaces, std::string(spaces.size(), ' '));
  EXPECT_GE(spaces.size(), drawn[drawn.size() - 3].find_last_not_of(' ') + 1);
}

TEST(Terminal, DrawsStatusAtMostTwentyTimesASecond) {
  const TemporaryFolder folder;
  const std::string problem = folder.write("long.yaml", kLong);
  const ProcessResult r =
      run_in_terminal({"solve", problem, "--max-time", "0.5", "-o", folder.path() / "out"}, {});
  EXPECT_EQ(r.exit_code, 1);
  const double seconds = nlohmann::json::parse(read_file(folder.path() / "out/solution.json"))
                             .at("time_s")
                             .at("total");
  EXPECT_LE(drawings(r.err).size(), 20 * seconds + 4);
  EXPECT_GE(drawings(r.err).size(), 3u);
}

TEST(Terminal, FitsNarrowTerminals) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_in_terminal(solve(folder), {.columns = 40, .environment = {"TERM=xterm"}});
  for (const std::string& drawn : drawings(r.err)) EXPECT_LT(drawn.size(), 40u) << drawn;
  const ProcessResult help = run_in_terminal({"solve", "--help"}, {.columns = 40});
  const ProcessResult wrong =
      run_in_terminal({"solve", kPendulum, "--thread", "2"}, {.columns = 40});
  EXPECT_EQ(wrong.exit_code, 2);
  for (const std::string& text : {help.out, wrong.err}) {
    EXPECT_NE(text, "");
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t end = std::min(text.find('\n', at), text.size());
      EXPECT_LE(shown_width(text.substr(at, end - at)), 40) << text.substr(at, end - at);
      at = end + 1;
    }
  }
}

TEST(Terminal, UsesColorOnlyOnRequest) {
  const TemporaryFolder folder;
  const auto out = [&](const char* term, const char* no_color) {
    return run_in_terminal(solve(folder), {.environment = {std::string("TERM=") + term,
                                                           std::string("NO_COLOR=") + no_color}});
  };
  const ProcessResult colour = out("xterm", "");
  EXPECT_NE(colour.out.find("\033[1;32mconverged"), std::string::npos) << colour.out;
  const ProcessResult plain = out("xterm", "1");
  EXPECT_EQ((plain.out + plain.err).find('\033'), std::string::npos);
  EXPECT_NE(plain.err, "");
  const ProcessResult dumb = out("dumb", "");
  EXPECT_EQ(dumb.out.find('\033'), std::string::npos);
  EXPECT_EQ(dumb.err, "") << "a terminal that cannot redraw shows no progress";
}

TEST(Terminal, VerboseIsATableEverywhere) {
  const TemporaryFolder folder;
  std::vector<std::string> arguments = solve(folder);
  arguments.push_back("-v");
  for (const bool terminal : {true, false}) {
    const ProcessResult r =
        run_in_terminal(arguments, {.environment = {"TERM=xterm"}, .err = terminal});
    EXPECT_NE(r.err.find(" iter           cost stationarity"), std::string::npos) << r.err;
    EXPECT_NE(r.err.find("\n    1 "), std::string::npos) << r.err;
    EXPECT_EQ(r.err.find('\r'), std::string::npos);
  }
}

TEST(Terminal, CtrlCWritesTheBestIterate) {
  const TemporaryFolder folder;
  const std::string problem = folder.write("long.yaml", kLong);
  const ProcessResult r =
      run_in_terminal({"solve", problem, "-o", folder.path() / "out"},
                      {.environment = {"TERM=xterm"}, .typed = "\x03", .type_after = "iteration"});
  EXPECT_EQ(r.exit_code, 130);
  EXPECT_NE(r.out.find("interrupted"), std::string::npos) << r.out;
  EXPECT_EQ(nlohmann::json::parse(read_file(folder.path() / "out/solution.json"))["status"],
            "interrupted");
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "out/trajectory.csv"));
}

/// True if a terminal would interpret part of the text as commands.
bool commands_a_terminal(const std::string& text) {
  for (const char* command : {"\x1B", "\xC2\x9B", "\xE2\x80\xA8", "\xE2\x80\xAE"})
    if (text.find(command) != text.npos) return true;
  return false;
}

TEST(Terminal, EscapesCommandsInNamesAndPaths) {
  const TemporaryFolder folder;
  const std::string raw =
      "\xC2\x9B"
      "31m\xE2\x80\xA8\xE2\x80\xAE";  // as UTF-8
  std::string text = read_file(kPendulum);
  text.replace(text.find("effort:"), 6, "\"effort" + raw + "\"");
  text.replace(text.find("name: pendulum_swingup"), 22, "name: \"p" + raw + "\"");
  const std::string problem = folder.write("p" + raw + ".yaml", text);
  const std::string out = folder.path() / ("out\x1B[31m" + raw);
  for (const std::vector<std::string>& arguments : std::vector<std::vector<std::string>>{
           {"solve", problem, "-o", out},
           {"solve", problem, "-o", out, "--json"},
           {"check", problem},
           {"check", problem, "--expand"},
           {"check", problem, "--json"},
           {"check", problem, "--set", "costs." + raw + "=1"},
           {"check", problem, "--set", "costs." + raw + "=1", "--diagnostics", "json"},
           {"verify", out + "/solution.json"},
           {"report", out + "/solution.json"},
           {"compare", out + "/solution.json", out + "/solution.json"},
           {"bench", problem, "--solvers", "box_fddp", "--repeat", "0"}}) {
    const ProcessResult r =
        run_in_terminal(arguments, {.environment = {"TERM=xterm", "NO_COLOR=1"}});
    EXPECT_LE(r.exit_code, 2);
    EXPECT_NE(r.out + r.err, "") << arguments[0];
    EXPECT_FALSE(commands_a_terminal(r.out)) << arguments[0] << "\n" << r.out;
    EXPECT_FALSE(commands_a_terminal(r.err)) << arguments[0] << "\n" << r.err;
  }
  // The document is unchanged.
  const auto json = nlohmann::json::parse(run_conddp({"check", problem, "--json"}).out);
  EXPECT_NE(json.dump().find(raw), std::string::npos);
  const std::string expanded = run_conddp({"check", problem, "--expand"}).out;
  const std::string again = folder.write("again.yaml", expanded);
  EXPECT_EQ(run_conddp({"check", again, "--expand"}).out, expanded);
}

}  // namespace
}  // namespace conddp
