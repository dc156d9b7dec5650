// --diagnostics=json: every stderr line is an object of schemas/diagnostic.schema.json.
#include <cstdlib>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// Runs the tool and returns its diagnostics, which must fit their schema.
std::vector<Json> diagnostics(const std::vector<std::string>& arguments, int exit_code = 2) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp(arguments);
  EXPECT_EQ(r.exit_code, exit_code) << r.err;
  std::vector<Json> list;
  std::istringstream lines(r.err);
  std::string command =
      source("scripts/validate_json") + " " + source("schemas/diagnostic.schema.json");
  for (std::string line; std::getline(lines, line);) {
    list.push_back(Json::parse(line));
    command += " " + folder.write(std::to_string(list.size()) + ".json", line);
  }
  EXPECT_FALSE(list.empty());
  EXPECT_TRUE(list.empty() || std::system((command + " >&2").c_str()) == 0);
  return list;
}

TEST(DiagnosticsJson, NamesAPlaceInAFile) {
  const TemporaryFolder folder;
  const std::string file = folder.write("p.yaml", "conddp: 1\nsytem: {type: pendulum}\n");
  Json first;
  for (const Json& d : diagnostics({"solve", file, "--diagnostics=json"}))
    if (d["message"] == "unknown key 'sytem'") first = d;
  ASSERT_TRUE(first.is_object());
  EXPECT_EQ(first["file"], file);
  EXPECT_EQ(first["line"], 2);
  EXPECT_EQ(first["column"], 1);
  EXPECT_EQ(first["severity"], "error");
  EXPECT_EQ(first["hint"], "did you mean 'system'?");
  const Json& accepted = first["accepted"];
  EXPECT_NE(std::find(accepted.begin(), accepted.end(), "system"), accepted.end());
}

TEST(DiagnosticsJson, UsageErrorsListAcceptedWords) {
  const Json command = diagnostics({"--diagnostics=json", "slove", "x"}).at(0);
  EXPECT_EQ(command["message"], "unknown subcommand 'slove'");
  EXPECT_EQ(command["hint"], "did you mean 'solve'?");
  EXPECT_TRUE(command["file"].is_null());
  const Json flag = diagnostics({"solve", "x", "--sovler", "ilqr", "--diagnostics", "json"}).at(0);
  EXPECT_EQ(flag["hint"], "did you mean '--solver'?");
  const Json value = diagnostics({"solve", "x", "--solver", "boxddp", "--diagnostics=json"}).at(0);
  EXPECT_EQ(value["hint"], "did you mean 'box_ddp' or 'box_fddp' or 'proxddp'?");
  EXPECT_EQ(value["accepted"].size(), solvers().size() + 1) << "auto, too";
  const Json kind = diagnostics({"list", "--diagnostics=json", "slovers"}).at(0);
  EXPECT_EQ(kind["hint"], "did you mean 'solvers'?");
  diagnostics({"--diagnostics=json"});
  diagnostics({"solve", "--diagnostics=json"});
  diagnostics({"solve", "a", "b", "--diagnostics=json"});
  diagnostics({"solve", "a", "--threads", "0", "--diagnostics=json"});
}

TEST(DiagnosticsJson, NamesUnknownCommandLineNames) {
  const Json drop =
      diagnostics({"solve", kPendulum, "--drop", "torqe", "--diagnostics=json"}).at(0);
  EXPECT_EQ(drop["hint"], "did you mean 'torque'?");
  EXPECT_EQ(drop["accepted"], Json{"torque"});
  const Json setting =
      diagnostics({"solve", kPendulum, "--set", "solver.nme=x", "--diagnostics=json"}).at(0);
  EXPECT_EQ(setting["file"], "--set");
  EXPECT_EQ(setting["column"], 8);
}

TEST(DiagnosticsJson, ReportsUnwritableOutputs) {
  const TemporaryFolder folder;
  const std::string file = folder.write("file", "");
  const Json error =
      diagnostics({"solve", kPendulum, "-o", file + "/out", "--diagnostics=json"}).at(0);
  EXPECT_NE(error["message"].get<std::string>().find("cannot be made"), std::string::npos);
}

TEST(DiagnosticsJson, NotesAndNoTableWhenVerbose) {
  const TemporaryFolder folder;
  const auto notes = diagnostics(
      {"solve", source("problems/arm_reach.yaml"), "-v", "--diagnostics=json", "-o", folder.path()},
      0);
  for (const Json& note : notes) EXPECT_EQ(note["severity"], "note");
}

TEST(DiagnosticsJson, DefaultsToTextAndNamesBadFormats) {
  const ProcessResult r = run_conddp({"solve", "x", "--diagnostics", "jsn"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("--diagnostics: there is no 'jsn'\n  hint: did you mean 'json'?"),
            std::string::npos)
      << r.err;
  EXPECT_EQ(run_conddp({"slove", "--diagnostics=text"}).err, run_conddp({"slove"}).err);
}

}  // namespace
}  // namespace conddp
