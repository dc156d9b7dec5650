#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

/// The data in a page.
nlohmann::json data_of(const std::filesystem::path& page) {
  const std::string text = read_file(page), open = "id=\"report-data\">";
  const std::size_t from = text.find(open) + open.size();
  return nlohmann::json::parse(text.substr(from, text.find("</script>", from) - from));
}

class ReportCommand : public testing::Test {
 protected:
  /// Solves the pendulum into a folder and returns the solution's file.
  std::string solve(const std::string& folder, const std::string& solver,
                    const std::string& problem = kPendulum) {
    const ProcessResult r = run_conddp(
        {"solve", problem, "--quiet", "--solver", solver, "-o", folder_.path() / folder});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return folder_.path() / folder / "solution.json";
  }
  TemporaryFolder folder_;
};

TEST_F(ReportCommand, SeveralSolutionsShareAPageBySolver) {
  const std::string page = folder_.path() / "both.html";
  const ProcessResult r =
      run_conddp({"report", solve("a", "box_fddp"), solve("b", "box_ddp"), "-o", page});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out, page + "\n");
  const nlohmann::json data = data_of(page);
  ASSERT_EQ(data["solutions"].size(), 2u);
  EXPECT_EQ(data["solutions"][0]["label"], "box_fddp");
  EXPECT_EQ(data["solutions"][1]["label"], "box_ddp");
  EXPECT_EQ(data["solutions"][1]["head"]["status"], "converged");
  EXPECT_FALSE(data["solutions"][0]["scene"].is_null());
  EXPECT_EQ(data["solutions"][0]["remark"], "");
}

TEST_F(ReportCommand, PageIsNextToFirstSolutionWithFolderLabels) {
  const ProcessResult r = run_conddp({"report", solve("a", "box_fddp"), solve("b", "box_fddp")});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const nlohmann::json data = data_of(folder_.path() / "a/report.html");
  EXPECT_EQ(data["solutions"][0]["label"], "a");
  EXPECT_EQ(data["solutions"][1]["label"], "b");
}

TEST_F(ReportCommand, DrawsSolutionWithoutProblemAndAddsARemark) {
  const std::string problem = folder_.write("gone.yaml", read_file(kPendulum));
  const std::string solution = solve("a", "box_fddp", problem);
  std::filesystem::remove(problem);
  const ProcessResult r = run_conddp({"report", solution});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("warning: its problem"), std::string::npos) << r.err;
  const nlohmann::json entry = data_of(folder_.path() / "a/report.html")["solutions"][0];
  EXPECT_TRUE(entry["scene"].is_null());
  EXPECT_NE(entry["remark"].get<std::string>().find("does not exist"), std::string::npos);
  EXPECT_EQ(entry["curves"]["x"]["values"].size(), 2u);
  EXPECT_EQ(run_conddp({"report", solution, "--problem", kPendulum}).err.find("does not exist"),
            std::string::npos);
}

TEST_F(ReportCommand, ShowsErrorsOfTheProblemOfASolution) {
  const std::string problem = folder_.write("changed.yaml", read_file(kPendulum));
  ASSERT_EQ(run_conddp({"solve", problem, "--quiet", "-o", folder_.path() / "a", "--set",
                        "solver.max_iterations=300", "--set", "costs.effort.weight=0.002"})
                .exit_code,
            0);
  const std::string solution = folder_.path() / "a/solution.json";
  // First an error in the file, then in a setting of the solution.
  for (const auto& [from, to, line] : {std::tuple("knots: 50", "knots: many", "changed.yaml:9:"),
                                       std::tuple("  effort:", "  effert:", "--set:1:")}) {
    std::string text = read_file(kPendulum);
    ASSERT_NE(text.find(from), std::string::npos) << from;
    folder_.write("changed.yaml", text.replace(text.find(from), std::string(from).size(), to));
    const ProcessResult r = run_conddp({"report", solution});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_NE(r.err.find(line), std::string::npos) << r.err;
    EXPECT_EQ(r.err.find("conddp.solution"), std::string::npos) << r.err;
  }
}

TEST_F(ReportCommand, RejectsBadSolutionsAndWritesNothing) {
  const std::string solution = solve("a", "box_fddp");
  const nlohmann::json good = nlohmann::json::parse(read_file(solution));
  const auto refused = [&](const std::string& text) {
    const std::string file = folder_.write("bad.json", text);
    const ProcessResult r = run_conddp({"report", file, "-o", folder_.path() / "bad.html"});
    EXPECT_EQ(r.exit_code, 2) << text.substr(0, 80);
    EXPECT_NE(r.err.find("bad.json"), std::string::npos) << r.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "bad.html"));
  };
  refused("{");
  refused("{}");
  refused(R"({"format": "conddp.solution/1"})");
  for (const char* key : {"trajectory", "problem", "solver", "log", "residuals"}) {
    nlohmann::json bad = good;
    bad.erase(key);
    refused(bad.dump());
    bad[key] = 7;
    refused(bad.dump());
  }
  for (const char* key : {"t", "x", "u", "columns", "phases"}) {
    nlohmann::json bad = good;
    bad["trajectory"].erase(key);
    refused(bad.dump());
    bad["trajectory"][key] = {1, 2};
    refused(bad.dump());
  }
  nlohmann::json bad = good;
  bad["trajectory"]["phases"][0]["knots"] = 1000000;
  refused(bad.dump());
  bad = good;
  bad["log"][0] = 7;
  refused(bad.dump());
  bad = good;
  bad["certificate"] = {{"holds", true}, {"checks", {1, 2}}};
  refused(bad.dump());
  bad = good;
  bad["multipliers"]["constraints"] = {
      {{"name", "a"}, {"node", 1000000}, {"value", {0}}, {"multiplier", {0}}}};
  refused(bad.dump());
}

TEST_F(ReportCommand, IncludesBenchResultsOfTheSameProblems) {
  const std::string solution = solve("a", "box_fddp");
  const ProcessResult measured =
      run_conddp({"bench", kPendulum, source("problems/cartpole_swingup_closed_form.yaml"),
                  "--solvers", "box_fddp,fddp", "--repeat", "0", "-o", folder_.path() / "bench"});
  ASSERT_EQ(measured.exit_code, 0) << measured.err;
  const std::string file = folder_.path() / "bench/bench.json";
  const ProcessResult r = run_conddp({"report", solution, "--bench", file});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const nlohmann::json bench = data_of(folder_.path() / "a/report.html")["bench"];
  ASSERT_EQ(bench["runs"].size(), 2u);
  EXPECT_EQ(bench["runs"][0]["solver"], "box_fddp");
  EXPECT_EQ(bench["runs"][0]["problem"], "pendulum_swingup");
  EXPECT_EQ(bench["runs"][1]["status"], "refused");

  const nlohmann::json good = nlohmann::json::parse(read_file(file));
  const auto refused = [&](const nlohmann::json& document, const std::string& why) {
    const std::string bad = folder_.write("bad.json", document.dump());
    const ProcessResult p =
        run_conddp({"report", solution, "--bench", bad, "-o", folder_.path() / "bad.html"});
    EXPECT_EQ(p.exit_code, 2);
    EXPECT_NE(p.err.find(why), std::string::npos) << p.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "bad.html"));
  };
  refused(nlohmann::json::parse(read_file(solution)), "not a benchmark of conddp");
  nlohmann::json bad = good;
  bad["runs"] = 7;
  refused(bad, "'runs' is not a list");
  bad = good;
  bad["runs"][0]["residuals"] = nullptr;
  refused(bad, "'residuals' is not an object");
  bad = good;
  bad["machine"] = "mine";
  refused(bad, "'machine' is not an object");
  bad = good;
  for (nlohmann::json& run : bad["runs"]) run["problem"] = "another";
  refused(bad, "no run on a problem of this page");
}

/// A report with a video, and a program in the place of Chromium.
class ReportVideo : public ReportCommand {
 protected:
  ReportVideo() {
    const std::string browser =
        folder_.write("bin/chromium", "#!/bin/sh\necho 'no display' >&2\nexit 1\n");
    std::filesystem::permissions(browser, std::filesystem::perms::owner_all);
  }
  ProcessResult record(const std::string& solution, const std::string& path) {
    return run_conddp({"report", solution, "--video", folder_.path() / "a.webm"},
                      {.environment = {"PATH=" + path}});
  }
  const std::string path_ = folder_.path() / "bin";
};

TEST_F(ReportVideo, MissingBrowserIsNamedWithItsPackage) {
  const ProcessResult r = record(solve("a", "box_fddp"), "/nowhere");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("install the package chromium"), std::string::npos) << r.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "a/report.html"));
}

TEST_F(ReportVideo, FailedRecordingWritesNothing) {
  const std::string solution = solve("a", "box_fddp");
  const std::vector<std::string> before = folder_.files();
  const ProcessResult r = record(solution, path_);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("bin/chromium' ended too early"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("no display"), std::string::npos) << r.err;
  EXPECT_EQ(folder_.files(), before);
}

TEST_F(ReportVideo, PageWithoutPictureIsAnError) {
  const std::string problem = folder_.write("gone.yaml", read_file(kPendulum));
  const std::string solution = solve("a", "box_fddp", problem);
  std::filesystem::remove(problem);
  const ProcessResult r = record(solution, path_);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("there is no picture to record: "), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("does not exist"), std::string::npos) << r.err;
}

}  // namespace
}  // namespace conddp
