// First problem files, and that they solve without an edit.
#include <algorithm>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

std::string robot(const std::string& name) { return source("problems/robots/" + name + ".urdf"); }

struct FirstFile {
  const char* name;
  const char* robot;
  Words motion;
  const char* part;  ///< of the file
};

class FirstProblem : public testing::TestWithParam<FirstFile> {};

TEST_P(FirstProblem, SolvesWithoutAnEdit) {
  const TemporaryFolder folder;
  const ProcessOptions here{.folder = folder.path()};
  Words words{"init", robot(GetParam().robot), "-o", "first.yaml"};
  words.insert(words.end(), GetParam().motion.begin(), GetParam().motion.end());
  const ProcessResult written = run_conddp(words, here);
  ASSERT_EQ(written.exit_code, 0) << written.err;
  EXPECT_EQ(written.out, "first.yaml\n");
  const std::string text = read_file(folder.path() / "first.yaml");
  EXPECT_NE(text.find(GetParam().part), std::string::npos) << text;
  EXPECT_LE(std::ranges::count(text, '\n'), 40) << text;
  const ProcessResult checked = run_conddp({"check", "first.yaml"}, here);
  EXPECT_EQ(checked.exit_code, 0) << checked.err;
  const ProcessResult solved = run_conddp({"solve", "first.yaml", "-o", "out"}, here);
  ASSERT_EQ(solved.exit_code, 0) << solved.out << solved.err;
  const Json solution = Json::parse(read_file(folder.path() / "out/solution.json"));
  EXPECT_EQ(solution.at("status"), "converged");
  EXPECT_EQ(solution.at("certificate").at("verdict"), "local_minimum");
}

INSTANTIATE_TEST_SUITE_P(
    Robots, FirstProblem,
    testing::Values(FirstFile{"Quadruped", "quadruped", {}, "LF: {frame: lf_foot}"},
                    FirstFile{"Trot", "quadruped", {"--gait", "trot"}, "type: trot"},
                    FirstFile{"Biped", "biped", {}, "type: surface"},
                    FirstFile{"Arm", "arm7", {}, "frame: tool"},
                    FirstFile{"Link", "arm7", {"--reach", "link_5"}, "frame: link_5"},
                    FirstFile{"Slider", "cartpole", {}, "frame: tip"},
                    FirstFile{"Quadrotor", "quadrotor", {}, "thrusters:"}),
    [](const auto& test) { return test.param.name; });

struct BadWish {
  const char* name;
  Words words;
  const char* message;
};

class BadFirstProblem : public testing::TestWithParam<BadWish> {};

TEST_P(BadFirstProblem, ExitsWithTwoAndAHint) {
  const TemporaryFolder folder;
  Words words = GetParam().words;
  words.insert(words.begin(), "init");
  const ProcessResult r = run_conddp(words, {.folder = folder.path()});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.out, "");
  EXPECT_NE(r.err.find(GetParam().message), std::string::npos) << r.err;
  EXPECT_EQ(folder.files(), Words{});
}

INSTANTIATE_TEST_SUITE_P(
    Wishes, BadFirstProblem,
    testing::Values(
        BadWish{"NoFile", {"absent.urdf"}, "'absent.urdf' does not exist"},
        BadWish{"Frame",
                {robot("arm7"), "--reach", "tol"},
                "the robot has no frame 'tol'\n  hint: did you mean 'tool'"},
        BadWish{"WalkingArm", {robot("arm7"), "--gait", "trot"}, "has no feet"},
        BadWish{"TrottingBiped", {robot("biped"), "--gait", "trot"}, "its gaits are: walk, jump"},
        BadWish{"NoRotors", {robot("free_body")}, "actuation: {thrusters:"},
        BadWish{"TwoMotions", {robot("quadruped"), "--stand", "--gait", "trot"}, "--gait"}),
    [](const auto& test) { return test.param.name; });

TEST(FirstProblemFile, IgnoresAnSrdfThatIsNone) {
  const TemporaryFolder folder;
  folder.write("arm.urdf", read_file(robot("arm7")));
  folder.write("arm.srdf", "<robot");
  const ProcessResult r = run_conddp({"init", "arm.urdf"}, {.folder = folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
}

TEST(FirstProblemFile, TakesThePostureOfAnSrdf) {
  const ProcessResult r = run_conddp({"init", robot("arm7"), "-o", "-"});
  EXPECT_NE(r.out.find(" of arm7.srdf, rad and m"), std::string::npos) << r.out;
}

TEST(FirstProblemFile, ReplacesAFileOnlyByForce) {
  const TemporaryFolder folder;
  const ProcessOptions here{.folder = folder.path()};
  folder.write("arm7.yaml", "mine");
  const ProcessResult kept = run_conddp({"init", robot("arm7")}, here);
  EXPECT_EQ(kept.exit_code, 2);
  EXPECT_NE(kept.err.find("'arm7.yaml' exists\n  hint: --force"), std::string::npos) << kept.err;
  EXPECT_EQ(read_file(folder.path() / "arm7.yaml"), "mine");
  EXPECT_EQ(run_conddp({"init", robot("arm7"), "--force"}, here).exit_code, 0);
  const ProcessResult printed = run_conddp({"init", robot("arm7"), "-o", "-"}, here);
  EXPECT_EQ(printed.out, read_file(folder.path() / "arm7.yaml"));
}

}  // namespace
}  // namespace conddp
