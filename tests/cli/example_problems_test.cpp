// Example problems in the folder `problems`, or else those installed with the tool.
#include <regex>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "child.hpp"
#include "pseudo_terminal.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::json;

/// Problem names of the source tree, which the tool beside it treats as installed.
std::set<std::string> our_problems(const char* folder = "problems") {
  std::set<std::string> names;
  for (const auto& entry : fs::directory_iterator(source(folder)))
    if (entry.path().extension() == ".yaml") names.insert(entry.path().stem());
  return names;
}

class ExampleProblems : public testing::Test {
 protected:
  ProcessResult run(const std::vector<std::string>& arguments) const {
    return run_conddp(arguments, {.folder = folder_.path()});
  }
  Json listed() const {
    const ProcessResult r = run({"list", "problems", "--json"});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return Json::parse(r.out)["problems"];
  }
  TemporaryFolder folder_;
};

TEST_F(ExampleProblems, AreListedWithTheirFeatures) {
  std::set<std::string> names;
  for (const Json& problem : listed()) {
    names.insert(problem["name"]);
    EXPECT_TRUE(fs::exists(problem["file"].get<std::string>())) << problem;
    EXPECT_GT(problem["description"].get<std::string>().size(), 20u) << problem;
    EXPECT_EQ(problem["description"].get<std::string>().find("schema"), std::string::npos);
  }
  std::set<std::string> ours = our_problems();
  ours.merge(our_problems("problems/mpc"));
  EXPECT_EQ(names, ours);
  const std::string text = run({"list", "problems"}).out;
  EXPECT_NE(text.find("\n  arm_reach "), std::string::npos) << text;
  EXPECT_NE(text.find("A seven-joint arm carries 10 kg to a pose half a metre away in 0.35 s, so"),
            std::string::npos);
}

TEST_F(ExampleProblems, AreSolvedByNameFromAnywhere) {
  const ProcessResult solved = run({"solve", "arm_reach", "-o", "out", "--quiet"});
  EXPECT_EQ(solved.exit_code, 0) << solved.err;
  EXPECT_EQ(run({"verify", "out/solution.json", "--quiet"}).exit_code, 0);
  EXPECT_EQ(run({"check", "pendulum_swingup"}).exit_code, 0);
  EXPECT_EQ(run({"check", "car_path"}).exit_code, 0);  // a closed loop
  const ProcessResult bench =
      run({"bench", "pendulum_swingup", "--solvers", "box_fddp", "--repeat", "0", "--json"});
  EXPECT_EQ(bench.exit_code, 0) << bench.err;
  const Json benched = Json::parse(bench.out)["runs"][0];
  EXPECT_NEAR(benched["best_known"].get<double>(), benched["cost"].get<double>(), 1e-8);
}

TEST_F(ExampleProblems, BestKnownOptimaFitTheSchema) {
  EXPECT_TRUE(fits_schema("best_known", read_file(source("problems/best_known.json"))));
}

TEST_F(ExampleProblems, FileAndFolderProblemsComeFirst) {
  std::string mine = read_file(kPendulum);
  mine.erase(0, mine.find("conddp: 1"));
  mine.replace(mine.find("name: pendulum_swingup"), 22, "name: mine");
  folder_.write("problems/arm_reach.yaml", "# Mine. Not the arm.\n" + mine);
  folder_.write("problems/new.yaml", mine);
  int found = 0;
  for (const Json& problem : listed()) {
    if (problem["name"] != "arm_reach" && problem["name"] != "new") continue;
    ++found;
    EXPECT_EQ(problem["file"], "problems/" + problem["name"].get<std::string>() + ".yaml");
    EXPECT_EQ(problem["description"], problem["name"] == "arm_reach" ? "Mine" : "(no description)");
  }
  EXPECT_EQ(found, 2);
  EXPECT_NE(run({"check", "arm_reach"}).out.find("mine"), std::string::npos);
  folder_.write("arm_reach", "no: problem\n");
  const ProcessResult r = run({"check", "arm_reach"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("arm_reach:1:1"), std::string::npos) << r.err;
}

TEST_F(ExampleProblems, BenchWithoutAFileUsesTheFolderProblems) {
  folder_.write("problems/one.yaml", read_file(kPendulum));
  const ProcessResult r = run({"bench", "--solvers", "all", "--json"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err,
            "conddp: note: no file given: using the problems of 'problems', with a limit of 10 s "
            "per solve\n");
  const Json report = Json::parse(r.out);
  EXPECT_EQ(report["runs"].size(), solvers().size());
  for (const Json& run : report["runs"]) {
    EXPECT_EQ(run["file"], "problems/one.yaml");
    EXPECT_EQ(run["options"]["max_time_s"], 10);
  }
}

TEST_F(ExampleProblems, FallsBackToInstalledProblems) {
  folder_.write("problems/notes.txt", "no problem");
  const ProcessResult r =
      run({"bench", "--solvers", "intro", "--repeat", "0", "--max-time", "0.001", "--json"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("conddp/problems', with a limit of 0.001 s per solve"), std::string::npos)
      << r.err;
  EXPECT_EQ(Json::parse(r.out)["runs"].size(), our_problems().size());
}

TEST_F(ExampleProblems, ReportsMissingExampleProblems) {
  fs::copy_file(conddp_binary(), folder_.path() / "lonely");
  const auto lonely = [&](const std::string& arguments) {
    const std::string command =
        "cd " + folder_.path().string() + " && ./lonely " + arguments + " >out 2>errors";
    return WEXITSTATUS(std::system(command.c_str()));
  };
  EXPECT_EQ(lonely("bench"), 2);
  EXPECT_NE(read_file(folder_.path() / "errors").find("no example problems"), std::string::npos);
  EXPECT_EQ(lonely("solve arm_reach"), 2);
  EXPECT_EQ(read_file(folder_.path() / "errors"),
            "conddp: error: 'arm_reach' is neither a file nor an example problem\n");
  EXPECT_EQ(lonely("list problems"), 0);
  EXPECT_NE(read_file(folder_.path() / "out").find("none here"), std::string::npos);
}

TEST_F(ExampleProblems, BenchShowsTheRemainingWork) {
  const ProcessResult r = run_in_terminal(
      {"bench", "pendulum_swingup", "--solvers", "box_ddp,fddp,box_fddp", "--repeat", "400"},
      {.columns = 100, .environment = {"TERM=xterm"}});
  EXPECT_EQ(r.exit_code, 0);
  // A solver that rejects the problem is not counted.
  EXPECT_NE(r.err.find(" s, 1 of 2, pendulum_swingup, box_ddp"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find(" s, 2 of 2, about "), std::string::npos) << r.err;
  EXPECT_TRUE(std::regex_search(r.err, std::regex(" left, [0-9.]+ solves/(s|min), pendulum")))
      << r.err;
}

}  // namespace
}  // namespace conddp
