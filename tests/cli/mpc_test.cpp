#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"
#include "support/balanced_cartpole.hpp"

namespace conddp {
namespace {

const std::string kBalance = std::string("conddp: 1\nname: balance\n") + kBalancing + R"(mpc:
  horizon: 1
  tick: 0.02
  duration: 2
  delay: 0.005
  feedback: {rate: 200}
  plant: {set: {system.pole_mass: 0.25}, dt: 0.005}
  disturbances: [{at: 1, jump: {omega: 1}}, {noise: state, sigma: 0.001, seed: 3}]
  fallback: {to: {values: {theta: 3.141592653589793}}}
  stop_when: {fallen: {residual: state, columns: theta, lower: 2.1, upper: 4.2}}
)";

class MpcCommand : public testing::Test {
 protected:
  MpcCommand() { folder_.write("balance.yaml", kBalance); }
  ProcessResult run(std::vector<std::string> arguments, const std::string& out) const {
    arguments.insert(arguments.begin(), {"mpc", "balance.yaml", "-o", out});
    return run_conddp(arguments, {.folder = folder_.path()});
  }
  std::string file(const std::string& name) const { return read_file(folder_.path() / name); }
  TemporaryFolder folder_;
};

TEST_F(MpcCommand, WritesALoopThatLastsItsDuration) {
  const ProcessResult result = run({}, "out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_NE(result.out.find("balance: finished at 2 s of 2 s\n"), std::string::npos) << result.out;
  EXPECT_NE(result.out.find("100 of 0.02 s by box_fddp, 0 failed\n"), std::string::npos)
      << result.out;
  EXPECT_TRUE(fits_schema("mpc", file("out/mpc.json")));
  const auto document = nlohmann::json::parse(file("out/mpc.json"));
  EXPECT_EQ(document["end"], "finished");
  EXPECT_EQ(document["outcomes"]["planned"], 100);
  EXPECT_NEAR(document["last_state"]["theta"].get<double>(), 3.14, 0.1);
  const std::string loop = file("out/closed_loop.csv"), ticks = file("out/ticks.csv");
  EXPECT_EQ(loop.find("t [s],phase,x [m],theta [rad],"), 0u) << loop.substr(0, 80);
  EXPECT_EQ(std::count(loop.begin(), loop.end(), '\n'), 1 + 400 + 1);
  EXPECT_EQ(std::count(ticks.begin(), ticks.end(), '\n'), 1 + 100);
}

// Double integrator with knots of 0.05 s. The cost with a predicted delay of two ticks comes from
// numpy.
TEST_F(MpcCommand, RememberedControlsActLate) {
  folder_.write("late.yaml", R"(conddp: 1
system:
  states: {x: m, v: m/s, u1: N, u2: N}
  controls: {u: N}
  next: {x: x + 0.05*v + 0.00125*u2, v: v + 0.05*u2, u1: u, u2: u1}
initial_state: {values: {x: 1, v: 0.5}}
phases: [{knots: 20, dt: 0.05}]
costs:
  state: {residual: expression, rows: [x, v]}
  effort: {residual: control, weight: 0.1}
terminal: {lqr: [0, 0, 0, 0]}
solver: {name: box_fddp}
mpc: {horizon: 1, tick: 0.05, duration: 10}
)");
  const ProcessResult late =
      run_conddp({"mpc", "late.yaml", "-o", "late"}, {.folder = folder_.path()});
  ASSERT_EQ(late.exit_code, 0) << late.err;
  EXPECT_NEAR(nlohmann::json::parse(file("late/mpc.json"))["cost"].get<double>(), 1.0027910, 1e-6);
  const ProcessResult longer =
      run_conddp({"mpc", "late.yaml", "--set", "mpc.delay=0.1"}, {.folder = folder_.path()});
  EXPECT_EQ(longer.exit_code, 2);
  EXPECT_NE(longer.err.find("states remember former controls"), std::string::npos) << longer.err;
}

TEST_F(MpcCommand, OutputIsReproducibleForAnyThreadCount) {
  ASSERT_EQ(run({"--quiet"}, "a").exit_code, 0);
  ASSERT_EQ(run({"--quiet"}, "b").exit_code, 0);
  const ProcessResult many = run({"--quiet", "--threads", "200"}, "c");
  ASSERT_EQ(many.exit_code, 0);
  EXPECT_EQ(many.err, "");
  for (const char* name : {"/closed_loop.csv", "/ticks.csv"}) {
    EXPECT_EQ(file(std::string("a") + name), file(std::string("b") + name));
    EXPECT_EQ(file(std::string("a") + name), file(std::string("c") + name));
  }
  EXPECT_EQ(file("a/mpc.json"), file("b/mpc.json"));
}

TEST_F(MpcCommand, CheckBuildsTheLoop) {
  const auto check = [&](std::vector<std::string> more) {
    more.insert(more.begin(), {"check", "balance.yaml"});
    return run_conddp(more, {.folder = folder_.path()});
  };
  const ProcessResult fine = check({});
  EXPECT_EQ(fine.exit_code, 0) << fine.err;
  EXPECT_NE(
      fine.out.find("  closed loop     2 s, ticks of 0.02 s with a horizon of 1 s, by box_fddp\n"),
      std::string::npos)
      << fine.out;
  const ProcessResult json = check({"--json"});
  EXPECT_TRUE(fits_schema("check", json.out)) << json.out;
  EXPECT_EQ(nlohmann::json::parse(json.out)["mpc"]["tick_s"], 0.02);
  const ProcessResult wrong = check({"--set", "mpc.tick=2"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_EQ(wrong.out, "");
  EXPECT_NE(wrong.err.find("a tick of 2 s is longer than the horizon of 1 s"), std::string::npos)
      << wrong.err;
  // Each message about the problem appears once.
  const ProcessResult once = check({"--set", "mesh={error: 1e-6}"});
  const std::string said = "'mesh' refines single solves";
  EXPECT_EQ(once.err.find(said), once.err.rfind(said)) << once.err;
  EXPECT_NE(once.err.find(said), std::string::npos) << once.err;
}

TEST_F(MpcCommand, ExitsWith1IfAConditionEndsTheLoop) {
  const ProcessResult result = run({"--set", "mpc.disturbances.0.jump.omega=20", "--json"}, "out");
  EXPECT_EQ(result.exit_code, 1) << result.err;
  const auto document = nlohmann::json::parse(result.out);
  EXPECT_EQ(document["end"], "stopped");
  EXPECT_EQ(document["message"], "the condition 'fallen' of stop_when does not hold");
  EXPECT_LT(document["end_time_s"], 1.5);
  EXPECT_EQ(result.out, file("out/mpc.json"));
}

TEST_F(MpcCommand, StoresCommandsForVerify) {
  const ProcessResult loop = run_conddp(
      {"mpc", "quadruped_commands", "-o", "out", "--set", "mpc.duration=0.1", "--set",
       "mpc.disturbances=[]", "--set", "mpc.commands=[{at: 0, velocity: [0.3, 0, 0], turn: 0.1}]"},
      {.folder = folder_.path()});
  ASSERT_EQ(loop.exit_code, 0) << loop.err;
  const ProcessResult good = run_conddp({"verify", "out/mpc.json"}, {.folder = folder_.path()});
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
}

TEST_F(MpcCommand, NamesDroppedConstraints) {
  ASSERT_EQ(run({}, "all").exit_code, 0);
  ASSERT_EQ(run({"--drop", "force"}, "out").exit_code, 0);
  EXPECT_TRUE(fits_schema("mpc", file("out/mpc.json")));
  const auto dropped = [&](const std::string& name) {
    return nlohmann::json::parse(file(name))["dropped_constraints"];
  };
  EXPECT_EQ(dropped("all/mpc.json"), nlohmann::json::array());
  EXPECT_EQ(dropped("out/mpc.json"), nlohmann::json::array({"force"}));
}

TEST_F(MpcCommand, StoresWhatVerifyReplays) {
  ASSERT_EQ(run({"--set", "solver.threads=2"}, "out").exit_code, 0);
  const auto verify = [&](const std::string& name, std::vector<std::string> more = {}) {
    more.insert(more.begin(), {"verify", name});
    return run_conddp(more, {.folder = folder_.path()});
  };
  const ProcessResult good = verify("out/mpc.json");
  EXPECT_EQ(good.exit_code, 0) << good.out << good.err;
  EXPECT_EQ(good.err, "");
  EXPECT_NE(good.out.find("balance: replayed ("), std::string::npos) << good.out;
  EXPECT_EQ(good.out.find("not checked"), std::string::npos) << good.out;
  auto document = nlohmann::json::parse(file("out/mpc.json"));
  document["cost"] = 1;
  std::filesystem::create_directory(folder_.path() / "out/alone");
  folder_.write("out/alone/edited.json", document.dump());
  const ProcessResult bad = verify("out/alone/edited.json");
  EXPECT_EQ(bad.exit_code, 1);
  EXPECT_NE(bad.out.find("DOES NOT HOLD: cost: claimed 1, found "), std::string::npos) << bad.out;
  EXPECT_NE(bad.out.find("not checked: there is no closed_loop.csv"), std::string::npos);
  for (const char* name : {"out/mpc.json", "out/alone/edited.json"})
    EXPECT_TRUE(fits_schema("verify", verify(name, {"--json"}).out));
}

TEST_F(MpcCommand, VerifyDetectsAnotherFile) {
  ASSERT_EQ(run({}, "out").exit_code, 0);
  std::string changed = kBalance;
  changed.replace(changed.find("tick: 0.02"), 10, "tick: 0.04");
  folder_.write("balance.yaml", changed);
  const ProcessResult other = run_conddp({"verify", "out/mpc.json"}, {.folder = folder_.path()});
  EXPECT_EQ(other.exit_code, 1) << other.err;
  EXPECT_NE(other.err.find("this file has changed"), std::string::npos) << other.err;
  EXPECT_NE(other.out.find("configuration: differs from the problem at /mpc/tick"),
            std::string::npos)
      << other.out;
  auto document = nlohmann::json::parse(file("out/mpc.json"));
  document.erase("end");
  folder_.write("out/mpc.json", document.dump());
  const ProcessResult lacking = run_conddp({"verify", "out/mpc.json"}, {.folder = folder_.path()});
  EXPECT_EQ(lacking.exit_code, 2);
  EXPECT_NE(lacking.err.find("the file cannot be used: 'end' is missing"), std::string::npos)
      << lacking.err;
}

TEST_F(MpcCommand, VerifyNoticesExtraMembersOfTheDocument) {
  ASSERT_EQ(run({}, "out").exit_code, 0);
  auto document = nlohmann::json::parse(file("out/mpc.json"));
  document["approved"] = true;
  folder_.write("out/mpc.json", document.dump());
  const ProcessResult verified = run_conddp({"verify", "out/mpc.json"}, {.folder = folder_.path()});
  EXPECT_EQ(verified.exit_code, 1) << verified.err;
  EXPECT_NE(verified.out.find("document: has 'approved'"), std::string::npos) << verified.out;
}

TEST_F(MpcCommand, VerifyDetectsAnotherFolder) {
  ASSERT_EQ(run({}, "out").exit_code, 0);
  auto document = nlohmann::json::parse(file("out/mpc.json"));
  document["problem"]["file"] = "stdin";
  folder_.write("out/mpc.json", document.dump());
  std::filesystem::create_directory(folder_.path() / "stdin");
  const ProcessResult verified = run_conddp({"verify", "out/mpc.json"}, {.folder = folder_.path()});
  EXPECT_EQ(verified.exit_code, 2);
  EXPECT_NE(verified.err.find("its problem 'stdin' does not exist"), std::string::npos)
      << verified.err;
}

TEST_F(MpcCommand, WarnsThatMeasuredSolvesAreNotReproducible) {
  const ProcessResult result = run({"--realtime"}, "out");
  EXPECT_NE(result.out.find(" late: outputs differ from run to run\n"), std::string::npos)
      << result.out << result.err;
  const std::string text = file("out/mpc.json");
  EXPECT_TRUE(fits_schema("mpc", text));
  EXPECT_EQ(nlohmann::json::parse(text)["clock"], "wall");
  const ProcessResult verified = run_conddp({"verify", "out/mpc.json"}, {.folder = folder_.path()});
  EXPECT_EQ(verified.exit_code, 0) << verified.out << verified.err;
}

TEST_F(MpcCommand, FindsTheLargestPushThatTheLoopSurvives) {
  const std::string key = "mpc.disturbances.0.jump.omega";
  const ProcessResult result = run({"--largest", key + "=[0, 32]"}, "out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  const std::string head = key + ": the loop lasts up to ";
  ASSERT_EQ(result.out.find(head), 0u) << result.out;
  const double largest = std::stod(result.out.substr(head.size()));
  const auto falls = [&](double push) {
    return run({"--set", fmt::format("{}={}", key, push)}, "alone").exit_code == 1;
  };
  EXPECT_FALSE(falls(largest));
  EXPECT_TRUE(falls(largest + 0.25));
  const std::string trials = file("out/largest.csv");
  EXPECT_EQ(trials.find(key + ",survived,end,time_s,cost,violation\n0,1,finished,2,"), 0u)
      << trials;
  EXPECT_EQ(std::count(trials.begin(), trials.end(), '\n'), 1 + 2 + 7);
  const auto document = nlohmann::json::parse(file("out/mpc.json"));
  EXPECT_EQ(document["end"], "finished");
  EXPECT_EQ(document["problem"]["overrides"][0], fmt::format("{}={}", key, largest));
}

TEST_F(MpcCommand, PrintsTheSearchResultAsJson) {
  const std::string key = "mpc.disturbances.0.jump.omega";
  const auto found = [&](const std::string& range) {
    const ProcessResult result = run({"--largest", key + "=" + range, "--json"}, "out");
    EXPECT_TRUE(fits_schema("mpc", result.out)) << result.out << result.err;
    auto document = nlohmann::json::parse(result.out);
    const auto largest = document["largest"];
    document.erase("largest");
    EXPECT_EQ(document, nlohmann::json::parse(file("out/mpc.json")));
    return largest;
  };
  EXPECT_EQ(found("[0, 0.5]"),
            (nlohmann::json{{"key", key}, {"low", 0.0}, {"high", 0.5}, {"survived", 0.5}}));
  EXPECT_TRUE(found("[20, 30]").at("survived").is_null());
}

TEST_F(MpcCommand, VerifyRejectsADifferentSearchResult) {
  const std::string key = "mpc.disturbances.0.jump.omega";
  const ProcessResult found = run({"--largest", key + "=[0, 1]", "--json"}, "out");
  const auto verdict = [&](const char* entry, const nlohmann::json& claim) {
    auto document = nlohmann::json::parse(found.out);
    if (entry != nullptr) document["largest"][entry] = claim;
    folder_.write("out/mpc.json", document.dump());
    return run_conddp({"verify", "out/mpc.json"}, {.folder = folder_.path()}).exit_code;
  };
  EXPECT_EQ(verdict(nullptr, {}), 0);
  EXPECT_NE(verdict("survived", 0.5), 0);
  EXPECT_NE(verdict("high", 0.5), 0);
  EXPECT_NE(verdict("key", "mpc.tick"), 0);
  EXPECT_NE(verdict("other", 1), 0);
}

TEST_F(MpcCommand, RejectsLoopsThatExceedMemory) {
  const ProcessResult result =
      run_conddp({"mpc", source("problems/mpc/biped_stepping.yaml"), "-o", "out"},
                 {.folder = folder_.path(), .limits = {.memory_bytes = 800'000'000}});
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("structures of windows, with up to 41 knots, need about"),
            std::string::npos)
      << result.err;
}

TEST_F(MpcCommand, CreatesTheFolderOfAReport) {
  const ProcessResult result = run({"--report", "pages/new/loop.html"}, "out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_FALSE(file("pages/new/loop.html").empty());
}

TEST_F(MpcCommand, SearchesAParameterOfThePlant) {
  std::string changed = kBalance;
  changed.replace(changed.find("system.pole_mass: 0.25"), 22, "system.pole_mass: =pm");
  folder_.write("balance.yaml", changed + "parameters: {pm: 0.25}\n");
  const ProcessResult result = run({"--largest", "parameters.pm=[0.1, 0.3]"}, "out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.find("parameters.pm: the loop lasts up to 0.3, the whole range\n"), 0u)
      << result.out;
}

TEST_F(MpcCommand, SearchesModelNumbersThatDifferInThePlant) {
  const std::string key = "mpc.plant.set.system.cart_mass";
  const ProcessResult result = run({"--largest", key + "=[0.9, 1.1]"}, "out");
  EXPECT_EQ(result.exit_code, 0) << result.err;
  EXPECT_EQ(result.out.find(key + ": the loop lasts up to 1.1, the whole range\n"), 0u)
      << result.out;
}

TEST_F(MpcCommand, ChecksKeyAndRangeBeforeTheFirstLoop) {
  struct Case {
    const char *argument, *message;
  };
  for (const auto& [argument, message] :
       {Case{"parameters.foo=[0, 1]", "'parameters.foo' is neither a number of the file"},
        Case{"name=[0, 5]", "'name' is neither a number of the file"},
        Case{"mpc.plant.set.system.weight=[0, 5]", "the plant cannot be built: unknown key"},
        Case{"mpc.delay=[0, 1]", "--largest:1:11: error: a delay of 1 s is longer than the tick"},
        Case{"mpc.disturbances.1.seed=[0, 5]", "--largest:1:25: error: "}}) {
    const ProcessResult result = run({"--largest", argument}, "out");
    EXPECT_EQ(result.exit_code, 2) << argument;
    EXPECT_NE(result.err.find(message), std::string::npos) << result.err;
    EXPECT_EQ(result.err.find("--set"), std::string::npos) << result.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out"));
  }
  std::string endless = kBalance;
  endless.erase(endless.find("  stop_when"));
  folder_.write("balance.yaml", endless);
  const ProcessResult result = run({"--largest", "mpc.disturbances.0.jump.omega=[0, 1000]"}, "out");
  EXPECT_EQ(result.exit_code, 2);
  EXPECT_NE(result.err.find("a loop without 'stop_when' never stops early"), std::string::npos)
      << result.err;
}

TEST_F(MpcCommand, CreatesSearchFolderBeforeTheFirstLoop) {
  folder_.write("taken", "a file");
  const std::string key = "mpc.disturbances.0.jump.omega";
  const ProcessResult result = run({"--largest", key + "=[0, 0.5]"}, "taken");
  EXPECT_NE(result.exit_code, 0);
  EXPECT_NE(result.err.find("the folder 'taken' cannot be made"), std::string::npos) << result.err;
}

TEST_F(MpcCommand, KeepsTrialsBeforeOneThatCannotBeBuilt) {
  std::string changed = kBalance;
  changed.replace(changed.find("{omega: 1}"), 10, "{omega: =10+10*pm+1e-9/pm}");
  folder_.write("balance.yaml", changed + "parameters: {pm: -1}\n");
  const ProcessResult result = run({"--largest", "parameters.pm=[-1, 1]"}, "out");
  EXPECT_EQ(result.exit_code, 2) << result.out << result.err;
  EXPECT_NE(result.err.find("--largest: the loop with parameters.pm=0 cannot be built"),
            std::string::npos)
      << result.err;
  const std::string trials = file("out/largest.csv");
  EXPECT_EQ(trials.find("parameters.pm,survived,end,time_s,cost,violation\n-1,1,finished,2,"), 0u)
      << trials;
  EXPECT_NE(trials.find("\n1,0,stopped,"), std::string::npos) << trials;
  EXPECT_EQ(nlohmann::json::parse(file("out/mpc.json"))["end"], "finished");
}

TEST_F(MpcCommand, ReportsSearchesWhereNoneOrAllSurvive) {
  const std::string key = "mpc.disturbances.0.jump.omega=";
  const ProcessResult none = run({"--largest", key + "[20, 30]"}, "out");
  EXPECT_EQ(none.exit_code, 1) << none.err;
  EXPECT_NE(none.out.find(": the loop fails at 20\n"), std::string::npos) << none.out;
  EXPECT_EQ(nlohmann::json::parse(file("out/mpc.json"))["end"], "stopped");
  const ProcessResult all = run({"--largest", key + "[0, 0.5]"}, "out");
  EXPECT_NE(all.out.find(": the loop lasts up to 0.5, the whole range\n"), std::string::npos)
      << all.out;
}

TEST_F(MpcCommand, RejectsInvalidRanges) {
  for (const char* bad : {"mpc.delay", "mpc.delay=3", "mpc.delay=[1]", "mpc.delay=[2, 1]",
                          "=[1, 2]", "mpc.delay=[0, x]"}) {
    const ProcessResult result = run({"--largest", bad}, "out");
    EXPECT_EQ(result.exit_code, 2) << bad;
    EXPECT_NE(result.err.find("is not KEY=[LOW, HIGH]"), std::string::npos) << result.err;
  }
  const ProcessResult unknown = run({"--largest", "mpc.delayed=[0, 1]"}, "out");
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("mpc.delayed"), std::string::npos) << unknown.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "out/largest.csv"));
}

}  // namespace
}  // namespace conddp
