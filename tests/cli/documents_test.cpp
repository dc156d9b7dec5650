// Schemas, help, manual pages, and lists of the tool.
#include <cstdlib>
#include <set>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "child.hpp"
#include "process.hpp"
#include "solvers/common/option_table.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/sizes.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

Words subcommands() {
  const std::string help = run_conddp({"--help"}).out;
  Words names;
  std::istringstream lines(help.substr(help.find("Subcommands:")));
  for (std::string line; std::getline(lines, line) && !line.empty();)
    if (line.starts_with("  ") && line[2] != ' ')
      names.push_back(line.substr(2, line.find(' ', 2) - 2));
  EXPECT_GE(names.size(), 7u);
  return names;
}

TEST(SchemaCommand, PrintsTheFilesByteForByte) {
  int count = 0;
  const std::string list = run_conddp({"schema"}).out;
  for (const auto& entry : std::filesystem::directory_iterator(source("schemas"))) {
    const std::string name = entry.path().filename();
    const std::string kind = name.substr(0, name.find('.'));
    const ProcessResult r = run_conddp({"schema", kind});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(r.out, read_file(entry.path())) << kind;
    EXPECT_NE(("\n" + list).find("\n" + kind + " "), std::string::npos) << list;
    ++count;
  }
  EXPECT_GE(count, 5);
  EXPECT_EQ(std::count(list.begin(), list.end(), '\n'), count);
}

TEST(ListCommand, NamesEverySolverAndOption) {
  const ProcessResult r = run_conddp({"list"});
  EXPECT_EQ(r.exit_code, 0);
  for (const SolverInfo& info : solvers())
    EXPECT_NE(r.out.find(std::string(info.description)), std::string::npos) << info.name;
  const std::string options = run_conddp({"list", "options"}).out;
  for (const OptionInfo& info : option_table())
    EXPECT_NE(options.find("  " + std::string(info.name) + " "), std::string::npos) << info.name;
  EXPECT_EQ(options.find("single shooting"), std::string::npos);
}

TEST(ListCommand, JsonFitsItsSchemaAndAgrees) {
  const std::string text = run_conddp({"list", "--json"}).out;
  EXPECT_TRUE(fits_schema("list", text));
  const Json all = Json::parse(text);
  const std::string plain = run_conddp({"list"}).out;
  for (const auto& [kind, entries] : all.items()) {
    for (const Json& entry : entries) {
      EXPECT_NE(plain.find("  " + entry["name"].get<std::string>() + " "), std::string::npos);
      for (const Json& key : entry.value("keys", Json::array()))
        EXPECT_NE(plain.find("      " + key["name"].get<std::string>() + " "), std::string::npos);
    }
    EXPECT_EQ(Json::parse(run_conddp({"list", kind, "--json"}).out), (Json{{kind, entries}}));
  }
}

/// Enumerated words of the problem file's schema, which tests compare with the reader.
TEST(ListCommand, HasTheWordsOfTheSchema) {
  const Json schema = Json::parse(run_conddp({"schema", "problem"}).out);
  const Json all = Json::parse(run_conddp({"list", "--json"}).out);
  const auto names = [&](const char* kind) {
    Json list = Json::array();
    for (const Json& entry : all[kind]) list.push_back(entry["name"]);
    return list;
  };
  const Json& d = schema["definitions"];
  EXPECT_EQ(names("solvers"), d["solver"]["properties"]["name"]["enum"]);
  EXPECT_EQ(names("residuals"), d["cost"]["properties"]["residual"]["enum"]);
  EXPECT_EQ(names("activations"), d["activation"]["anyOf"][1]["properties"]["kind"]["enum"]);
  EXPECT_EQ(names("integrators"), schema["properties"]["integrator"]["enum"]);
  EXPECT_EQ(names("constraints"), d["constraint"]["properties"]["bounds"]["enum"]);
}

TEST(ListCommand, MatchesSchemaAndFuzzerDictionary) {
  const std::string command = source("scripts/write_schema") + " --check " + conddp_binary();
  EXPECT_EQ(std::system(command.c_str()), 0) << "run scripts/write_schema";
}

TEST(ListCommand, ReaderThatLeavesIsNoError) {
  const TemporaryFolder folder;
  const std::string errors = folder.path() / "errors";
  const std::string command = std::string("bash -c 'set -o pipefail; ") + conddp_binary() +
                              " list 2>" + errors + " | head -1 >/dev/null'";
  EXPECT_EQ(std::system(command.c_str()), 0);
  EXPECT_EQ(read_file(errors), "");
}

TEST(ListCommand, UnwritableResultsAreAnError) {
  const TemporaryFolder folder;
  const std::string errors = folder.path() / "errors";
  for (const char* redirection : {">/dev/full", ">&-"}) {
    const int status =
        std::system((conddp_binary() + " list " + redirection + " 2>" + errors).c_str());
    EXPECT_EQ(WEXITSTATUS(status), 2);
    EXPECT_NE(read_file(errors).find("cannot be written to stdout"), std::string::npos);
  }
}

TEST(InspectCommand, JsonFitsItsSchema) {
  for (const auto& entry : std::filesystem::directory_iterator(source("problems/robots"))) {
    if (entry.path().extension() != ".urdf") continue;
    const ProcessResult r = run_conddp({"inspect", entry.path(), "--json"});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_TRUE(fits_schema("inspect", r.out)) << entry;
  }
  const Json arm =
      Json::parse(run_conddp({"inspect", source("problems/robots/arm7.urdf"), "--json"}).out);
  EXPECT_EQ(arm["joints"].size(), 7u);
  EXPECT_EQ(arm["joints"][1]["lower"], -2.09);
  EXPECT_EQ(arm["links"][1], (Json{{"name", "link_1"}, {"joint", "joint_1"}, {"mass_kg", 4.2}}));
  EXPECT_DOUBLE_EQ(arm["mass_kg"]["total"], 18);
}

TEST(InspectCommand, TotalMassIncludesFixedBodies) {
  const TemporaryFolder folder;
  const std::string file = folder.write("r.urdf", R"(<robot name="r">
  <link name="foot"><inertial><mass value="2"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="arm"><inertial><mass value="3"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="j" type="continuous"><parent link="foot"/><child link="arm"/><axis xyz="0 0 1"/></joint>
</robot>
)");
  const Json fixed = Json::parse(run_conddp({"inspect", file, "--json"}).out);
  EXPECT_EQ(fixed["mass_kg"], (Json{{"total", 5.0}, {"moving", 3.0}}));
  EXPECT_EQ(fixed["joints"][0]["type"], "continuous");
  EXPECT_TRUE(fixed["joints"][0]["upper"].is_null());
  const Json free = Json::parse(run_conddp({"inspect", file, "--base", "floating", "--json"}).out);
  EXPECT_EQ(free["mass_kg"], (Json{{"total", 5.0}, {"moving", 5.0}}));
}

TEST(Help, IsEqualByOptionAndSubcommand) {
  EXPECT_EQ(run_conddp({"help"}).out, run_conddp({"--help"}).out);
  for (const std::string& name : subcommands()) {
    const ProcessResult r = run_conddp({"help", name});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(r.out, run_conddp({name, "--help"}).out);
    EXPECT_NE(r.out.find("Usage: conddp " + name), std::string::npos) << r.out;
  }
}

TEST(Help, UsesEightyColumnsInAPipe) {
  Words texts = {run_conddp({"--help"}).out};
  for (const std::string& name : subcommands()) texts.push_back(run_conddp({name, "--help"}).out);
  for (const std::string& text : texts) {
    std::istringstream lines(text);
    for (std::string line; std::getline(lines, line);) EXPECT_LE(line.size(), 80u) << line;
  }
}

TEST(ManualPages, AreValidRoffAndComplete) {
  const TemporaryFolder folder;
  const ProcessResult all = run_conddp({"man", "--output", folder.path() / "man1"});
  EXPECT_EQ(all.exit_code, 0) << all.err;
  Words expected = {"man1/conddp.1"};
  for (const std::string& name : subcommands()) {
    expected.push_back("man1/conddp-" + name + ".1");
    EXPECT_EQ(run_conddp({"man", name}).out, read_file(folder.path() / expected.back()));
  }
  std::sort(expected.begin(), expected.end());
  EXPECT_EQ(folder.files(), expected);
  for (const std::string& page : expected) {
    const std::string warnings = folder.path() / "warnings", text = folder.path() / "text";
    const std::string command = "groff -man -Tascii -P-cbou -ww " +
                                (folder.path() / page).string() + " >" + text + " 2>" + warnings;
    EXPECT_EQ(std::system(command.c_str()), 0);
    EXPECT_EQ(read_file(warnings), "") << page;
    for (const char* section : {"NAME", "Usage:", "Options:", "ENVIRONMENT"})
      EXPECT_NE(read_file(text).find(section), std::string::npos) << page;
  }
  EXPECT_NE(read_file(folder.path() / "man1/conddp-solve.1").find("\\-\\-max\\-time"),
            std::string::npos);
}

/// Flags of a help text: words with a dash at the start of a list entry.
Words flags(const std::string& help) {
  Words names;
  std::istringstream lines(help);
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("  -") && !line.starts_with("      --")) continue;
    const std::size_t start = line.find("--");
    names.push_back(line.substr(start, line.find(' ', start) - start));
  }
  return names;
}

TEST(CommandLineReference, MentionsEverySubcommandAndFlag) {
  const std::string text = read_file(source("docs/command_line.md"));
  for (const std::string& flag : flags(run_conddp({"--help"}).out))
    EXPECT_NE(text.find("`" + flag), std::string::npos) << flag;
  for (const std::string& name : subcommands()) {
    const std::size_t start = text.find("\n## `conddp " + name);
    ASSERT_NE(start, std::string::npos) << name;
    const std::string section = text.substr(start, text.find("\n## ", start + 1) - start);
    for (const std::string& flag : flags(run_conddp({name, "--help"}).out)) {
      // Shared by all subcommands, or by all that read problem files.
      if (flag == "--help" || flag == "--diagnostics" || flag == "--allow-code") continue;
      EXPECT_NE(section.find(flag), std::string::npos) << name << " " << flag;
    }
  }
}

TEST(Gallery, ShowsEveryExampleProblem) {
  EXPECT_EQ(std::system((source("scripts/gallery") + " --check").c_str()), 0);
}

TEST(Documents, LinksResolveAndProblemFilesAreWellFormed) {
  EXPECT_EQ(std::system((source("scripts/check_documents") + " " + conddp_binary()).c_str()), 0);
}

TEST(Documents, ShowOutputsOfTheProgram) {
  if (kSmallSizes) GTEST_SKIP() << "solves of minutes";
  EXPECT_EQ(std::system((source("scripts/check_documents") + " --run " + conddp_binary()).c_str()),
            0);
}

TEST(CommandLineReference, HasTheExitCodes) {
  const std::string text = read_file(source("docs/command_line.md"));
  const std::string help = run_conddp({"--help"}).out;
  std::istringstream lines(help.substr(help.find("Exit status:")));
  std::string line;
  std::getline(lines, line);
  int count = 0;
  for (; std::getline(lines, line);) {
    if (!std::isdigit(static_cast<unsigned char>(line.at(2)))) continue;
    const std::string code = line.substr(2, line.find(' ', 2) - 2);
    EXPECT_NE(text.find("\n| " + code + " |"), std::string::npos) << code;
    ++count;
  }
  EXPECT_EQ(count, 6);
}

}  // namespace
}  // namespace conddp
