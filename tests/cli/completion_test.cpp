// Completion scripts in their shells.
#include <array>
#include <cstdio>
#include <sstream>

#include <sys/wait.h>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "child.hpp"
#include "process.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

struct ShellResult {
  int exit_code = -1;
  std::string out;
};

ShellResult shell(const std::string& command) {
  ShellResult result;
  FILE* pipe = popen(command.c_str(), "r");
  std::array<char, 4096> buffer;
  while (const std::size_t n = fread(buffer.data(), 1, buffer.size(), pipe))
    result.out.append(buffer.data(), n);
  const int status = pclose(pipe);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return result;
}

std::string quoted(const std::string& word) { return "'" + word + "'"; }

const std::string kFolder = std::filesystem::path(conddp_binary()).parent_path();

using Words = std::vector<std::string>;

/// Candidates that bash offers for the last word.
Words bash_offers(const Words& words, const std::string& folder = source("")) {
  std::string command = "cd " + quoted(folder) + " && bash --norc " +
                        quoted(source("tests/cli/complete.bash")) + " " + quoted(kFolder);
  for (const std::string& word : words) command += " " + quoted(word);
  const ShellResult result = shell(command + " 2>&1");
  EXPECT_EQ(result.exit_code, 0) << result.out;
  Words offers;
  std::istringstream lines(result.out);
  for (std::string line; std::getline(lines, line);) offers.push_back(line);
  return offers;
}

Words solver_names() {
  Words names{"auto"};
  for (const SolverInfo& info : solvers()) names.emplace_back(info.name);
  return names;
}

bool has(const Words& offers, const std::string& word) {
  return std::find(offers.begin(), offers.end(), word) != offers.end();
}

TEST(BashCompletion, SolverNames) {
  EXPECT_EQ(bash_offers({"conddp", "solve", "p.yaml", "--solver", ""}), solver_names());
  Words boxes;
  for (const std::string& name : solver_names())
    if (name.starts_with("box")) boxes.push_back(name);
  EXPECT_GE(boxes.size(), 2u);
  EXPECT_EQ(bash_offers({"conddp", "solve", "--solver", "box"}), boxes);
  // bash splits --solver=box at '='.
  EXPECT_EQ(bash_offers({"conddp", "solve", "--solver", "=", "box"}), boxes);
  EXPECT_EQ(bash_offers({"conddp", "solve", "--solver", "="}), solver_names());
}

TEST(BashCompletion, SubcommandsAndKinds) {
  EXPECT_EQ(bash_offers({"conddp", "sol"}), Words{"solve"});
  EXPECT_EQ(bash_offers({"conddp", "--diagnostics", "json", "sol"}), Words{"solve"});
  EXPECT_EQ(bash_offers({"conddp", "help", "sol"}), Words{"solve"});
  EXPECT_EQ(bash_offers({"conddp", "list", "solv"}), Words{"solvers"});
  EXPECT_TRUE(has(bash_offers({"conddp", "schema", ""}), "problem"));
  EXPECT_EQ(bash_offers({"conddp", "completion", "z"}), Words{"zsh"});
  EXPECT_EQ(bash_offers({"conddp", "inspect", "r.urdf", "--base", "f"}),
            (Words{"fixed", "floating"}));
}

TEST(BashCompletion, FilesByTheirKindAndFolders) {
  const TemporaryFolder folder;
  for (const char* name : {"a.yaml", "a.urdf", "a.json", "sub/b.yaml"}) folder.write(name, "");
  EXPECT_EQ(bash_offers({"conddp", "solve", ""}, folder.path()), (Words{"sub", "a.yaml"}));
  EXPECT_EQ(bash_offers({"conddp", "inspect", ""}, folder.path()), (Words{"sub", "a.urdf"}));
  EXPECT_EQ(bash_offers({"conddp", "solve", "a.yaml", "-o", ""}, folder.path()), Words{"sub"});
}

/// Every long option in the help of a subcommand.
Words flags_in_help(const std::string& subcommand) {
  Words flags;
  std::istringstream lines(run_conddp({subcommand, "--help"}).out);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t start = line.find("--");
    if (start != line.npos && start <= 6 && line.starts_with("  "))
      flags.push_back(line.substr(start, line.find(' ', start) - start));
  }
  return flags;
}

TEST(BashCompletion, EveryFlagOfEverySubcommand) {
  const Words subcommands = bash_offers({"conddp", ""});
  EXPECT_GE(subcommands.size(), 7u);
  for (const std::string& subcommand : subcommands) {
    const Words offers = bash_offers({"conddp", subcommand, "--"});
    const Words flags = flags_in_help(subcommand);
    EXPECT_GE(flags.size(), 2u) << subcommand;
    for (const std::string& flag : flags) EXPECT_TRUE(has(offers, flag)) << subcommand << flag;
  }
}

void expect_zsh(const std::string& line, const Words& expected) {
  std::string command =
      quoted(source("tests/cli/complete.zsh")) + " " + quoted(kFolder) + " " + quoted(line);
  for (const std::string& word : expected) command += " " + quoted(word);
  const ShellResult result = shell("zsh -f " + command + " 2>&1");
  EXPECT_EQ(result.exit_code, 0) << line << "\n" << result.out;
}

TEST(ZshCompletion, WorksInAnInteractiveShell) {
  expect_zsh("conddp ", {"solve", "inspect", "completion"});
  expect_zsh("conddp solve p.yaml --solver ", solver_names());
  expect_zsh("conddp solve p.yaml --", flags_in_help("solve"));
  expect_zsh("conddp solve p.yaml --solver=i", {"ilqr"});
  expect_zsh("conddp bench p.yaml --", flags_in_help("bench"));
  expect_zsh("conddp list ", {"solvers", "residuals"});
}

TEST(FishCompletion, SolverNamesFlagsAndFiles) {
  const TemporaryFolder home;  // fish creates folders in it
  const auto offers = [&](const std::string& line) {
    const ShellResult result = shell(
        "cd " + quoted(source("")) +
        " && env -u XDG_CONFIG_HOME -u XDG_DATA_HOME HOME=" + quoted(home.path()) + " fish -c " +
        fmt::format("'set PATH {} $PATH; conddp completion fish | source; complete -C \"{}\"'",
                    kFolder, line));
    EXPECT_EQ(result.exit_code, 0) << result.out;
    Words words;
    std::istringstream lines(result.out);
    for (std::string text; std::getline(lines, text);)
      words.push_back(text.substr(0, text.find('\t')));
    return words;
  };
  for (const std::string& name : solver_names())
    EXPECT_TRUE(has(offers("conddp solve p.yaml --solver "), name)) << name;
  for (const std::string& flag : flags_in_help("solve"))
    EXPECT_TRUE(has(offers("conddp solve p.yaml --"), flag)) << flag;
  EXPECT_EQ(offers("conddp help sol"), Words{"solve"});
  EXPECT_TRUE(has(offers("conddp solve problems/arm"), "problems/arm_reach.yaml"));
}

TEST(Completion, NamesTheSupportedShells) {
  const ProcessResult r = run_conddp({"completion", "fsh"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("did you mean 'fish'"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace conddp
