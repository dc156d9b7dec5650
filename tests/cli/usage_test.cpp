#include <gtest/gtest.h>

#include "process.hpp"

namespace conddp {
namespace {

using Files = std::vector<std::string>;

struct Mistake {
  const char* name;
  Files arguments;
  const char* message;
};

class BadUsage : public testing::TestWithParam<Mistake> {};

TEST_P(BadUsage, ExitsWithTwoAndAHint) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp(GetParam().arguments, {.folder = folder.path()});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.out, "");
  EXPECT_NE(r.err.find(GetParam().message), std::string::npos) << r.err;
  EXPECT_EQ(r.err.find("internal error"), std::string::npos) << r.err;
  EXPECT_EQ(folder.files(), Files{});
}

const std::string kProblem = source("problems/pendulum_swingup.yaml");

INSTANTIATE_TEST_SUITE_P(
    Classes, BadUsage,
    testing::Values(
        Mistake{"Nothing", {}, "a subcommand is required"},
        Mistake{"Subcommand", {"slove", kProblem}, "did you mean 'solve'?"},
        Mistake{"NoFile", {"solve"}, "FILE"},
        Mistake{"Flag", {"solve", kProblem, "--sovler", "ilqr"}, "did you mean '--solver'?"},
        Mistake{"TwoFiles", {"solve", kProblem, kProblem}, "conddp: error:"},
        Mistake{"SetSwallowsNothing", {"solve", kProblem, "--set", "a=1", "b=2"}, "conddp: error:"},
        Mistake{"Threads", {"solve", kProblem, "--threads", "0"}, "--threads"},
        Mistake{"MaxTime", {"solve", kProblem, "--max-time", "soon"}, "--max-time"},
        Mistake{"QuietAndVerbose", {"solve", kProblem, "--quiet", "-v"}, "--quiet"},
        Mistake{"Solver", {"solve", kProblem, "--solver", "boxddp"}, "did you mean 'box_ddp'"},
        Mistake{"Refused", {"solve", kProblem, "--solver", "fddp"}, "--drop torque"},
        Mistake{"Drop", {"solve", kProblem, "--drop", "torqe"}, "did you mean 'torque'?"},
        Mistake{"Setting", {"solve", kProblem, "--set", "solver.nme=x"}, "--set:1:8: error"},
        Mistake{"Absent", {"solve", "absent.yaml"}, "'absent.yaml' does not exist"},
        Mistake{"Folder", {"solve", "/tmp"}, "'/tmp' is a folder"},
        Mistake{"Device", {"solve", "/dev/zero"}, "'/dev/zero' is not a regular file"},
        Mistake{"Inspect", {"inspect", "absent.urdf"}, "'absent.urdf' does not exist"},
        Mistake{"Reach",
                {"reach", "absent.urdf", "--frame", "tip", "--at", "[0,0,0]"},
                "'absent.urdf' does not exist"},
        Mistake{"ReachFrame", {"reach", "absent.urdf", "--at", "[0,0,0]"}, "--frame"},
        Mistake{"InspectBase", {"inspect", "x.urdf", "--base", "free"}, "--base"}),
    [](const auto& test) { return test.param.name; });

TEST(Usage, HelpAndVersionGoToStdout) {
  for (const Files& arguments :
       {Files{"--help"}, Files{"solve", "--help"}, Files{"inspect", "-h"}, Files{"--version"}}) {
    const ProcessResult r = run_conddp(arguments);
    EXPECT_EQ(r.exit_code, 0);
    EXPECT_NE(r.out, "");
    EXPECT_EQ(r.err, "");
  }
  EXPECT_TRUE(run_conddp({"--version"}).out.starts_with("conddp "));
}

TEST(Usage, DiagnosticsShowTheLineAndACaret) {
  const TemporaryFolder folder;
  const std::string file = folder.write("p.yaml", "conddp: 1\nsytem: {type: pendulum}\n");
  const ProcessResult r = run_conddp({"solve", file});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find(file + ":2:1: error: unknown key 'sytem'\n  sytem: {type: pendulum}\n"
                              "  ^\n  hint: did you mean 'system'?\n"),
            std::string::npos)
      << r.err;
}

TEST(Usage, PathsInAProblemAreRelativeToIt) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"solve", source("problems/arm_reach.yaml"), "--quiet"},
                                     {.folder = folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
}

TEST(Inspect, ShowsTheRobot) {
  const ProcessResult r = run_conddp({"inspect", source("problems/robots/arm7.urdf")});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  for (const char* part : {"arm7: 7 degrees of freedom", "joint_4 (revolute): link_4", "18 kg",
                           "-2.09", "conddp ignores", "tool"})
    EXPECT_NE(r.out.find(part), std::string::npos) << part << "\n" << r.out;
}

TEST(Inspect, NamesErrors) {
  const TemporaryFolder folder;
  const std::string file = folder.write(
      "r.urdf", "<robot name=\"r\">\n  <link name=\"a\"/>\n  <link name=\"b\"/>\n</robot>\n");
  const ProcessResult r = run_conddp({"inspect", file});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("r.urdf:"), std::string::npos) << r.err;
}

TEST(Reach, PrintsJointsThatFilesTake) {
  const std::string robot = source("problems/robots/arm7.urdf");
  const Files wish = {"reach", robot,           "--frame", "tool", "--at", "[0.5, -0.2, 0.3]",
                      "--rpy", "[3.1416, 0, 0]"};
  const ProcessResult first = run_conddp(wish);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_TRUE(first.out.starts_with("joints:\n  \"joint_1\": ")) << first.out;
  // From the answer, nothing moves.
  const TemporaryFolder folder;
  std::string state = first.out;
  for (std::size_t at = 0; (at = state.find('\n', at)) != std::string::npos; at += 3)
    state.replace(at, 1, "\n  ");
  const std::string file = folder.write(
      "p.yaml", "conddp: 1\nrobot: {urdf: " + robot + "}\ninitial_state:\n  " + state +
                    "\nphases: [{knots: 3, dt: 0.1}]\ncosts: {effort: {residual: control}}\n");
  const ProcessResult again = run_conddp(
      {"reach", file, "--frame", "tool", "--at", "[0.5, -0.2, 0.3]", "--rpy", "[3.1416, 0, 0]"});
  EXPECT_EQ(again.exit_code, 0) << again.err;
  for (std::size_t joint = 1; joint <= 7; ++joint) {
    const std::string key = "\"joint_" + std::to_string(joint) + "\": ";
    const auto value = [&](const std::string& text) {
      return std::stod(text.substr(text.find(key) + key.size()));
    };
    EXPECT_NEAR(value(again.out), value(first.out), 1e-6);
  }
}

TEST(Reach, StartsFromAConfigurationOfAProblem) {
  const std::string problem = source("problems/arm_shelf.yaml");
  const auto first_of = [&](Files wish) {
    wish.insert(wish.begin(), {"reach", problem, "--frame", "tool", "--at", "0.5,0,0.7"});
    const ProcessResult r = run_conddp(wish);
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return r.out;
  };
  EXPECT_NE(first_of({"--from", "high"}), first_of({}));
  EXPECT_EQ(run_conddp({"reach", source("problems/cartpole_swingup_closed_form.yaml"), "--frame",
                        "tool", "--at", "0,0,0"})
                .exit_code,
            2);
}

TEST(Reach, NamesPlacesOutOfReach) {
  const ProcessResult r = run_conddp({"reach", source("problems/robots/double_pendulum.urdf"),
                                      "--frame", "tip", "--at", "[0, 0, -1.1]"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.out, "");
  EXPECT_NE(r.err.find("no joint positions were found that put 'tip' there: it stays 0.2 m away"),
            std::string::npos)
      << r.err;
}

}  // namespace
}  // namespace conddp
