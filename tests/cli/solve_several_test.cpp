// conddp solve with several files, and with the standard input.
#include <cstdlib>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "child.hpp"
#include "process.hpp"

namespace conddp {
namespace {

TEST(SolveSeveral, WritesOneFolderEachAndReturnsWorstStatus) {
  const TemporaryFolder folder;
  const std::string a = folder.write("a.yaml", read_file(kPendulum)),
                    b = folder.write("b.yaml", read_file(source("problems/pendulum_goal.yaml")));
  const std::string out = folder.path() / "out";
  EXPECT_EQ(run_conddp({"solve", a, b, "-o", out, "--quiet"}).exit_code, 0);
  for (const char* name : {"a", "b"})
    EXPECT_NE(read_file(out + "/" + name + "/solution.json"), "") << name;
  EXPECT_EQ(run_conddp({"solve", a, b, "-o", out, "--quiet", "--set", "solver.max_iterations=1"})
                .exit_code,
            1);
}

TEST(SolveSeveral, SolvesNothingIfOneFileIsWrong) {
  const TemporaryFolder folder;
  const std::string a = folder.write("a.yaml", read_file(kPendulum)),
                    b = folder.write("b.yaml", "conddp: 1\nsytem: {}\n");
  const ProcessResult r = run_conddp({"solve", a, b, "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("b.yaml:2:1: error: unknown key 'sytem'"), std::string::npos) << r.err;
  EXPECT_EQ(folder.files(), (std::vector<std::string>{"a.yaml", "b.yaml"}));
}

TEST(SolveSeveral, EqualFileNamesAreAnError) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"solve", kPendulum, kPendulum}, {.folder = folder.path()});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("two problems would be written to 'out/pendulum_swingup'"),
            std::string::npos)
      << r.err;
  EXPECT_TRUE(folder.files().empty());
}

TEST(SolveStandardInput, ActsLikeAFile) {
  const TemporaryFolder folder;
  const std::string file = folder.write("p.yaml", read_file(kPendulum));
  const std::string out = folder.path();
  const auto piped = [&](const std::string& text, const std::string& rest) {
    const std::string command =
        text + " | " + conddp_binary() + " solve - " + rest + " > " + out + "/log 2>&1";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(piped("cat " + file, "-o " + out + "/piped"), 0) << read_file(out + "/log");
  EXPECT_EQ(run_conddp({"solve", file, "-o", out + "/read"}).exit_code, 0);
  const auto a = nlohmann::json::parse(read_file(out + "/piped/solution.json")),
             b = nlohmann::json::parse(read_file(out + "/read/solution.json"));
  EXPECT_EQ(a["trajectory"], b["trajectory"]);
  EXPECT_EQ(a["problem"]["sha256"], b["problem"]["sha256"]);
  EXPECT_EQ(piped("true", ""), 2);
  EXPECT_NE(read_file(out + "/log").find("there is nothing in the document"), std::string::npos);
  EXPECT_EQ(piped("printf 'conddp: 2\\n'", ""), 2);
  EXPECT_NE(read_file(out + "/log").find("stdin:1:9: error"), std::string::npos)
      << read_file(out + "/log");
}

}  // namespace
}  // namespace conddp
