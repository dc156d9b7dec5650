#include <algorithm>
#include <cstdlib>
#include <functional>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

/// A folder with a problem, its robot, and its solution in out/.
class Verify : public testing::Test {
 protected:
  Verify() {
    problem_ = read_file(source("problems/cartpole_swingup.yaml"));
    folder_.write("cartpole.yaml", problem_);
    std::filesystem::create_directory(folder_.path() / "robots");
    folder_.write("robots/cartpole.urdf", read_file(source("problems/robots/cartpole.urdf")));
    solved_ = run({"solve", "cartpole.yaml", "-o", "out"});
    solution_ = read_file(folder_.path() / "out/solution.json");
  }
  ProcessResult run(const std::vector<std::string>& arguments) const {
    return run_conddp(arguments, {.folder = folder_.path()});
  }
  /// Writes a solution with changes and verifies it.
  template <class Change>
  ProcessResult verify(Change change) const {
    Json json = Json::parse(solution_);
    change(json);
    folder_.write("out/changed.json", json.dump());
    return run({"verify", "out/changed.json"});
  }

  TemporaryFolder folder_;
  std::string problem_, solution_;
  ProcessResult solved_;
};

TEST_F(Verify, ASolutionHolds) {
  EXPECT_EQ(solved_.exit_code, 0) << solved_.err;
  EXPECT_NE(solved_.out.find("\n  certificate   certified local minimum ("), std::string::npos)
      << solved_.out;
  const ProcessResult r = run({"verify", "out/solution.json"});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  EXPECT_EQ(r.err, "");
  EXPECT_NE(r.out.find("cartpole_swingup: certified local minimum ("), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("\n  ok    stationarity "), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("\n  replay at dt/10: with feedback "), std::string::npos) << r.out;
}

TEST_F(Verify, FindsTheProblemFromOtherFolders) {
  const ProcessResult r =
      run_conddp({"verify", "solution.json"}, {.folder = folder_.path() / "out"});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
}

TEST_F(Verify, ChangesFail) {
  const ProcessResult control = verify([](Json& json) { json["trajectory"]["u"][20][0] = 0.123; });
  EXPECT_EQ(control.exit_code, 1) << control.err;
  EXPECT_NE(control.out.find("DOES NOT HOLD: cost: claimed "), std::string::npos) << control.out;
  EXPECT_NE(control.out.find("  knot 20 (phase 'swing'), v/hinge\n"), std::string::npos)
      << control.out;
  EXPECT_EQ(verify([](Json& json) { json["cost"] = 1; }).exit_code, 1);
  EXPECT_EQ(verify([](Json& json) { json["status"] = "time_limit"; }).exit_code, 1);
  EXPECT_EQ(verify([](Json& json) { json["trajectory"]["x"].erase(7); }).exit_code, 1);
}

TEST_F(Verify, JsonFitsItsSchema) {
  const ProcessResult good = run({"verify", "out/solution.json", "--json"});
  EXPECT_TRUE(Json::parse(good.out)["certificate"]["holds"].get<bool>());
  folder_.write("good.json", good.out);
  Json changed = Json::parse(solution_);
  changed["trajectory"]["x"][5][0] = 1e300;
  folder_.write("changed.json", changed.dump());
  const ProcessResult bad = run({"verify", "changed.json", "--json"});
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_FALSE(Json::parse(bad.out)["certificate"]["holds"].get<bool>());
  folder_.write("bad.json", bad.out);
  const std::string command = source("scripts/validate_json") + " " +
                              source("schemas/verify.schema.json") + " " +
                              (folder_.path() / "good.json").string() + " " +
                              (folder_.path() / "bad.json").string() + " >&2";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

TEST_F(Verify, ReportsAChangedProblemFile) {
  folder_.write("cartpole.yaml", problem_ + "# a remark\n");
  const ProcessResult remark = run({"verify", "out/solution.json"});
  EXPECT_EQ(remark.exit_code, 0) << remark.out;
  EXPECT_NE(remark.err.find("cartpole.yaml: warning: this file has changed"), std::string::npos)
      << remark.err;
  std::string heavier = problem_;
  heavier.replace(heavier.find("weight: 200"), 11, "weight: 201");
  folder_.write("cartpole.yaml", heavier);
  const ProcessResult other = run({"verify", "out/solution.json"});
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_NE(other.out.find("configuration"), std::string::npos);
  EXPECT_NE(other.out.find("/terminal/costs/upright/weight"), std::string::npos) << other.out;
}

TEST_F(Verify, ChangedRobotFails) {
  std::string robot = read_file(source("problems/robots/cartpole.urdf"));
  const std::size_t mass = robot.find("<mass value=\"");
  robot.replace(mass, 13, "<mass value=\"1");
  folder_.write("robots/cartpole.urdf", robot);
  const ProcessResult r = run({"verify", "out/solution.json"});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_NE(r.err.find("cartpole.urdf: warning: this file has changed"), std::string::npos)
      << r.err;
  EXPECT_NE(r.out.find("FAILS gap"), std::string::npos) << r.out;
}

TEST_F(Verify, AcceptsTheProblemFromAnotherPlace) {
  std::filesystem::create_directory(folder_.path() / "elsewhere");
  std::filesystem::rename(folder_.path() / "cartpole.yaml", folder_.path() / "moved.yaml");
  const ProcessResult lost = run({"verify", "out/solution.json"});
  EXPECT_EQ(lost.exit_code, 2);
  EXPECT_NE(lost.err.find("its problem 'cartpole.yaml' does not exist"), std::string::npos)
      << lost.err;
  EXPECT_EQ(run({"verify", "out/solution.json", "--problem", "moved.yaml"}).exit_code, 0);
}

// A solution may name any file; the contents of files that are not problems or robots stay hidden.
TEST_F(Verify, QuotesNothingFromFilesThatAreNotProblems) {
  folder_.write("text.txt", "hushhush\n");
  folder_.write("users.txt", "conddp:x:999:hushhush\n");
  folder_.write("text.csv", "t,hushhush\n1,hushhush\n");
  const auto names = [](const std::string& file) {
    return [file](Json& json) { json["problem"]["file"] = file; };
  };
  const auto sets = [](const std::string& setting) {
    return [setting](Json& json) { json["problem"]["overrides"] = {setting}; };
  };
  const std::function<void(Json&)> forgeries[] = {names("text.txt"),
                                                  names("users.txt"),
                                                  sets("robot.urdf=text.txt"),
                                                  sets("costs.effort.reference={file: text.csv}"),
                                                  sets("costs.effort.reference={file: text.txt}"),
                                                  sets("tables={t: {file: text.csv, x: a, y: b}}")};
  for (const auto& forge : forgeries) {
    const ProcessResult verified = verify(forge);
    EXPECT_EQ(verified.exit_code, 2);
    EXPECT_NE(verified.err.find("' cannot be built"), std::string::npos) << verified.err;
    EXPECT_EQ((verified.out + verified.err).find("hushhush"), std::string::npos) << verified.err;
    for (const std::vector<std::string>& arguments :
         {std::vector<std::string>{"report", "out/changed.json", "-o", "page.html"},
          {"contacts", "out/changed.json", "-o", "schedule.yaml"}}) {
      const ProcessResult r = run(arguments);
      EXPECT_EQ((r.out + r.err).find("hushhush"), std::string::npos) << r.err;
    }
    if (const auto page = folder_.path() / "page.html"; std::filesystem::exists(page)) {
      EXPECT_EQ(read_file(page).find("hushhush"), std::string::npos);
    }
    // A problem from the command line with settings of the solution.
    const ProcessResult other = run({"verify", "out/changed.json", "--problem", "cartpole.yaml"});
    EXPECT_EQ((other.out + other.err).find("hushhush"), std::string::npos) << other.err;
  }
  // Files named on the command line are quoted, as are problems with errors.
  const ProcessResult named = run({"verify", "out/solution.json", "--problem", "text.txt"});
  EXPECT_EQ(named.exit_code, 2);
  EXPECT_NE(named.err.find("hushhush"), std::string::npos) << named.err;
  folder_.write("cartpole.yaml", problem_ + "hushhush: 1\n");
  const ProcessResult wrong = run({"verify", "out/solution.json"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("  hushhush: 1\n"), std::string::npos) << wrong.err;
}

TEST_F(Verify, RemembersCommandLineChanges) {
  EXPECT_EQ(run({"solve", "cartpole.yaml", "-o", "two", "--solver", "fddp", "--drop", "force",
                 "--set", "costs.effort.weight=0.05", "--warm-start", "out/solution.json",
                 "--threads", "2", "--max-time", "100"})
                .exit_code,
            0);
  std::filesystem::remove(folder_.path() / "out/solution.json");
  const ProcessResult r = run({"verify", "two/solution.json"});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  const std::string head = r.out.substr(0, r.out.find('\n'));
  EXPECT_TRUE(head.ends_with(" checks), with settings")) << head;
  EXPECT_NE(r.out.find("\n  setting costs.effort.weight=0.05\n"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("\n  dropped force\n"), std::string::npos) << r.out;
  const Json json = Json::parse(run({"verify", "two/solution.json", "--json"}).out)["settings"];
  EXPECT_EQ(json["dropped_constraints"], Json::array({"force"}));
  EXPECT_NE(
      std::find(json["overrides"].begin(), json["overrides"].end(), "costs.effort.weight=0.05"),
      json["overrides"].end())
      << json;
}

TEST_F(Verify, ReportsTolerancesThatLetTheAnswerPass) {
  std::string loose = problem_;
  const std::string last = "max_iterations: 300}";
  loose.replace(loose.find(last), last.size(), "tolerances: {constraint: 10}}");
  folder_.write("cartpole.yaml", loose);
  const ProcessResult solved = run({"solve", "cartpole.yaml", "-o", "loose"});
  EXPECT_EQ(solved.exit_code, 0);
  EXPECT_NE(
      solved.out.find(" checks)\n                tolerances beyond the defaults: constraint 10"),
      std::string::npos)
      << solved.out;
  const ProcessResult r = run({"verify", "loose/solution.json"});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  EXPECT_NE(r.out.find("\n  tolerances beyond the defaults: constraint 10 (default "),
            std::string::npos)
      << r.out;
  EXPECT_EQ(r.out.find("with settings"), std::string::npos) << r.out;
}

TEST_F(Verify, UnconvergedAnswerHoldsToo) {
  const ProcessResult solved =
      run({"solve", "cartpole.yaml", "-o", "early", "--set", "solver.max_iterations=2"});
  EXPECT_EQ(solved.exit_code, 1) << solved.err;
  EXPECT_NE(solved.out.find("certificate   consistency check passed"), std::string::npos)
      << solved.out;
  EXPECT_NE(solved.out.find("diagnosis     the solve stopped"), std::string::npos) << solved.out;
  EXPECT_EQ(run({"verify", "early/solution.json"}).exit_code, 0);
}

TEST_F(Verify, RejectsBadInput) {
  EXPECT_EQ(run({"verify", "nothing.json"}).exit_code, 2);
  EXPECT_EQ(run({"verify", "cartpole.yaml"}).exit_code, 2);
  folder_.write("list.json", "[1, 2]");
  EXPECT_EQ(run({"verify", "list.json"}).exit_code, 2);
  for (const char* key : {"problem", "trajectory", "multipliers", "cost", "log"}) {
    const ProcessResult r = verify([&](Json& json) { json.erase(key); });
    EXPECT_EQ(r.exit_code, 2) << key;
    EXPECT_NE(r.err.find(key), std::string::npos) << r.err;
    EXPECT_EQ(r.out, "");
  }
  for (const char* key : {"trajectory", "residuals", "log", "gains", "cost_by_name"})
    EXPECT_EQ(verify([&](Json& json) { json[key] = 5; }).exit_code, 2) << key;
  EXPECT_EQ(verify([&](Json& json) { json["trajectory"]["x"][3][0] = "a"; }).exit_code, 2);
}

TEST_F(Verify, CertificateIsAnOptionalFieldOfTheSolution) {
  const Json json = Json::parse(solution_);
  EXPECT_TRUE(json["certificate"]["holds"].get<bool>());
  EXPECT_GT(json["certificate"]["checks"].size(), 20u);
  EXPECT_EQ(json["diagnosis"]["pattern"], "normal");
  const ProcessResult r = run({"solve", "cartpole.yaml", "-o", "plain", "--no-verify"});
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_EQ(r.out.find("certificate"), std::string::npos);
  EXPECT_FALSE(
      Json::parse(read_file(folder_.path() / "plain/solution.json")).contains("certificate"));
}

}  // namespace
}  // namespace conddp
