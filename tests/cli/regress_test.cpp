// conddp compare and conddp regress.
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

const std::string kGolden = source("tests/golden/pendulum_swingup.json");

bool has(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

TEST(Compare, SolutionAgreesWithItsGoldenFile) {
  const TemporaryFolder folder;
  run_conddp({"solve", kPendulum, "--quiet", "-o", folder.path()});
  const ProcessResult r = run_conddp({"compare", kGolden, folder.path() / "solution.json"});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  EXPECT_TRUE(has(r.out, "agrees with")) << r.out;
}

TEST(Compare, NamesDifferencesBeyondTheTolerance) {
  const TemporaryFolder folder;
  Json other = Json::parse(read_file(kGolden));
  other["cost"] = other["cost"].get<double>() * 1.01;
  const std::string file = folder.write("other.json", other.dump());
  const ProcessResult r = run_conddp({"compare", kGolden, file});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_TRUE(has(r.out, "  cost: 0.0185886722 instead of 0.0184046259 (difference ")) << r.out;
  EXPECT_EQ(std::count(r.out.begin(), r.out.end(), '\n'), 2) << r.out;
  EXPECT_EQ(run_conddp({"compare", kGolden, file, "--tolerance", "cost_relative=0.02"}).exit_code,
            0);
}

TEST(Compare, RejectsFilesThatAreNotSolutions) {
  const TemporaryFolder folder;
  Json other = Json::parse(read_file(kGolden));
  other["trajectory"]["x"][3].erase(0);
  const ProcessResult r =
      run_conddp({"compare", kGolden, folder.write("other.json", other.dump())});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.out, "");
  EXPECT_TRUE(has(r.err, "cannot be compared: a row of 'x' should have 2 numbers")) << r.err;
}

TEST(Regress, ExampleProblemsHaveTheirKnownAnswers) {
  const TemporaryFolder folder;
  const std::string report = folder.path() / "report.xml";
  const ProcessResult r =
      run_conddp({"regress", kGolden, source("tests/golden/quadruped_trot.json"),
                  source("tests/golden/block_slope.json"), "--junit", report});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  EXPECT_TRUE(has(r.out, "3 agree, 0 differ\n")) << r.out;
  EXPECT_TRUE(has(read_file(report), "name=\"quadruped_trot\"")) << read_file(report);
  EXPECT_FALSE(has(read_file(report), "<failure"));
}

/// A copy of the pendulum with its golden file beside it.
struct Copy {
  Copy() {
    problem = folder.write("problem.yaml", read_file(kPendulum));
    const ProcessResult added = run_conddp({"regress", folder.path(), "--add", problem});
    EXPECT_EQ(added.exit_code, 0) << added.err;
    EXPECT_TRUE(has(added.out, "1 written")) << added.out;
  }
  ProcessResult regress(const std::vector<std::string>& more = {}) const {
    std::vector<std::string> arguments = {"regress", folder.path()};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_conddp(arguments);
  }
  TemporaryFolder folder;
  std::string problem;
};

TEST(Regress, OnePercentWeightChangeGivesAReadableDifference) {
  const Copy copy;
  EXPECT_EQ(copy.regress().exit_code, 0);
  const std::string report = copy.folder.path() / "report.xml";
  const ProcessResult r = copy.regress({"--set", "costs.effort.weight=1.01e-3", "--junit", report});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_TRUE(has(r.out, "problem: DIFFERS (")) << r.out;
  EXPECT_TRUE(has(r.out, "\n  cost: 0.0184643")) << r.out;
  EXPECT_TRUE(has(r.out, "\n  cost effort: ")) << r.out;
  EXPECT_TRUE(has(r.out, "\n  trajectory torque at knot ")) << r.out;
  EXPECT_TRUE(has(r.out, "0 agree, 1 differ\n")) << r.out;
  EXPECT_TRUE(has(read_file(report), "failures=\"1\"")) << read_file(report);
  EXPECT_TRUE(has(read_file(report), "<failure message=\"cost: 0.0184643")) << read_file(report);
}

TEST(Regress, BlessShowsTheDifferenceAndWritesTheAnswer) {
  const Copy copy;
  std::string text = read_file(copy.problem);
  const std::size_t at = text.find("weight: 1.0e-3");
  ASSERT_NE(at, std::string::npos);
  copy.folder.write("problem.yaml", text.replace(at, 14, "weight: 1.01e-3"));
  EXPECT_EQ(copy.regress().exit_code, 1);
  const ProcessResult blessed = copy.regress({"--bless"});
  EXPECT_EQ(blessed.exit_code, 0) << blessed.err;
  EXPECT_TRUE(has(blessed.out, "problem: DIFFERS (")) << blessed.out;
  EXPECT_TRUE(has(blessed.out, "1 written")) << blessed.out;
  EXPECT_EQ(copy.regress().exit_code, 0);
  const std::string before = read_file(copy.folder.path() / "problem.json");
  copy.regress({"--bless"});
  EXPECT_EQ(read_file(copy.folder.path() / "problem.json"), before);
}

TEST(Regress, GoldenTolerancesAreLocalAndSurviveBlessing) {
  const Copy copy;
  const std::string golden = copy.folder.path() / "problem.json";
  Json answer = Json::parse(read_file(golden));
  answer["tolerances"] = {{"cost_relative", 0.1}, {"trajectory_absolute", 0.1}};
  copy.folder.write("problem.json", answer.dump());
  const std::vector<std::string> heavier = {"--set", "costs.effort.weight=1.01e-3"};
  EXPECT_EQ(copy.regress(heavier).exit_code, 0);
  const ProcessResult strict =
      copy.regress({"--set", "costs.effort.weight=1.01e-3", "--tolerance", "cost_relative=1e-6"});
  EXPECT_EQ(strict.exit_code, 1) << strict.out;
  answer["iterations"] = 1;
  copy.folder.write("problem.json", answer.dump());
  EXPECT_TRUE(has(copy.regress({"--bless"}).out, "1 written"));
  const Json blessed = Json::parse(read_file(golden));
  EXPECT_NE(blessed["iterations"], 1);
  EXPECT_EQ(blessed["tolerances"], answer["tolerances"]);
}

TEST(Regress, UnreadableProblemDoesNotStopTheOthers) {
  const Copy copy;
  Json golden = Json::parse(read_file(copy.folder.path() / "problem.json"));
  golden["problem"]["file"] = "gone.yaml";
  copy.folder.write("gone.json", golden.dump());
  const std::string report = copy.folder.path() / "report.xml";
  const ProcessResult r = copy.regress({"--junit", report});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_TRUE(has(r.err, "gone.yaml' does not exist")) << r.err;
  EXPECT_TRUE(has(r.out, "1 agree, 0 differ, 1 cannot be solved\n")) << r.out;
  EXPECT_TRUE(has(read_file(report), "errors=\"1\"")) << read_file(report);
}

TEST(Regress, UnreadableGoldenFileDoesNotStopTheOthers) {
  const Copy copy;
  copy.folder.write("cut.json", read_file(kGolden).substr(0, 400));
  const ProcessResult r = copy.regress({});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_TRUE(has(r.err, "cut.json:")) << r.err;
  EXPECT_TRUE(has(r.out, "1 agree, 0 differ, 1 cannot be solved\n")) << r.out;
}

TEST(Regress, AddsGoldenFilesToAnExistingFolder) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"regress", folder.path() / "none", "--add", kPendulum});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_TRUE(has(r.err, "none' is not a folder")) << r.err;
}

TEST(Regress, DoesNotOverwriteExistingGoldenFilesByAdding) {
  const Copy copy;
  const ProcessResult r = copy.regress({"--add", copy.problem});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_TRUE(has(r.err, "problem.json' exists")) << r.err;
}

}  // namespace
}  // namespace conddp
