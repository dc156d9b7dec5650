// Checks of closed loops by `verify`.
#include "output/report/loop_certificate.hpp"

#include <fstream>

#include "base/files/text_file.hpp"
#include "base/json/json_document.hpp"
#include "loop_fixture.hpp"
#include "output/report/certificate_report.hpp"
#include "support/source_tree.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

class LoopVerdict : public testing::Test {
 protected:
  void write(const SimulatedLoop& loop) const { write_loop(loop.run(), folder_); }
  LoopCertificate judge(const SimulatedLoop& loop, const OrderedJson& document) const {
    return certify_loop(document, folder_, *loop.task);
  }
  void expect_holds(const SimulatedLoop& loop) const {
    write(loop);
    const LoopCertificate certificate = judge(loop, loop_json(loop.run()));
    EXPECT_TRUE(certificate.checks.holds()) << certificate_table(certificate.checks);
    EXPECT_TRUE(certificate.missing.empty());
  }
  std::string text(const char* name) const { return read_text_file(folder_ / name, 1 << 24).text; }
  void replace_text(const char* name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  /// Names of the failed checks in one line.
  static std::string failures(const LoopCertificate& certificate) {
    std::string names;
    for (const Check& check : certificate.checks.checks)
      if (!check.holds) names += check.name + ';';
    return names;
  }

  const TemporaryFolder temporary_;
  const std::filesystem::path folder_ = temporary_.path();
};

/// A table row with one cell replaced.
std::string with_cell(const std::string& text, int line, int cell, const std::string& value) {
  std::size_t begin = 0;
  for (int i = 1; i < line; ++i) begin = text.find('\n', begin) + 1;
  for (int i = 1; i < cell; ++i) begin = text.find(',', begin) + 1;
  std::string changed = text;
  return changed.replace(begin, text.find_first_of(",\n", begin) - begin, value);
}

TEST_F(LoopVerdict, HoldsWithJumpsNoiseDelayAndAnotherPlant) {
  expect_holds(SimulatedLoop(kBalancedCartpole));
}

TEST_F(LoopVerdict, HoldsWithSimulatedContactsCommandsAndRetiming) {
  const TextFile file =
      read_text_file(source_tree() / "problems/mpc/quadruped_commands.yaml", 1 << 20);
  expect_holds(SimulatedLoop(
      file.text, {"robot.urdf=robots/quadruped.urdf", "mpc.duration=1", "mpc.disturbances=[]",
                  "mpc.commands.1.at=0.5", "mpc.commands.2.at=0.7"}));
}

/// Text of an example problem.
std::string example(const char* name) {
  return read_text_file(source_tree() / "problems" / name, 1 << 20).text;
}

TEST_F(LoopVerdict, AllowsForRoundedTimesAtStepEndRate) { expect_holds(SimulatedLoop(kStiffMass)); }

TEST_F(LoopVerdict, RoundedTimesStandForKnotEnds) {
  const std::string mpc =
      "mpc={horizon: 0.3, tick: 0.00777777777, duration: 0.8, plant: {dt: "
      "0.00333333333}, repeat: hold}";
  expect_holds(SimulatedLoop(example("hopper_jump.yaml"), {mpc}));
}

TEST_F(LoopVerdict, RoundedTimesStandForPushesJumpsAndCommands) {
  const auto settings = [](const char* tick) {
    return std::vector<std::string>{
        std::string("mpc={horizon: 0.3, tick: ") + tick +
        ", duration: 0.9, repeat: gait, plant: {dt: 0.002}, disturbances: [{at: 0.1, frame: trunk, "
        "force: [0, 40, 0], duration: 0.1}, {at: 0.2, jump: {base/vz: 0.1}}], commands: [{at: 0.4, "
        "velocity: [0.3, 0, 0]}]}"};
  };
  for (const char* tick : {"0.0333333333", "0.03999999995625"}) {
    SCOPED_TRACE(tick);
    expect_holds(SimulatedLoop(example("quadruped_trot.yaml"), settings(tick)));
  }
}

TEST_F(LoopVerdict, HoldsIfAPhaseIsAJump) { expect_holds(SimulatedLoop(kBouncingMass)); }

TEST_F(LoopVerdict, HoldsForATrotThatIsPushed) {
  const auto file = source_tree() / "problems/quadruped_trot.yaml";
  expect_holds(SimulatedLoop(read_text_file(file, 1 << 20).text,
                             {"mpc={horizon: 0.3, tick: 0.02, duration: 0.4, repeat: gait, "
                              "disturbances: [{at: 0.1, frame: "
                              "trunk, force: [0, 40, 0], duration: 0.05}]}"}));
}

TEST_F(LoopVerdict, HoldsForAFallenLoop) {
  const SimulatedLoop loop(kBalancedCartpole, {"mpc.disturbances.0.jump.omega=20"});
  EXPECT_EQ(loop.result.end, LoopEnd::stopped);
  expect_holds(loop);
}

TEST_F(LoopVerdict, HoldsForAnInterruptedLoop) {
  SimulatedLoop loop(kBalancedCartpole);
  loop.task->mpc.loop.interrupted = [left = 20]() mutable { return left-- == 0; };
  loop.result = run_loop(*loop.task);
  loop.task->mpc.loop.interrupted = nullptr;
  EXPECT_EQ(loop.result.end, LoopEnd::interrupted);
  expect_holds(loop);
}

TEST_F(LoopVerdict, ReplaysLateTicksOfTheFile) {
  const SimulatedLoop loop(kBalancedCartpole, {}, {10, 11, 12});
  expect_holds(loop);
  OrderedJson document = loop_json(loop.run());
  EXPECT_EQ(document["late_ticks"], (std::vector<int>{10, 11, 12}));
  document["late_ticks"] = {10, 11};
  EXPECT_NE(failures(judge(loop, document)).find("outcomes/late;"), std::string::npos);
}

TEST_F(LoopVerdict, HoldsForLateAnswersOfTheFile) {
  const SimulatedLoop loop(kBalancedCartpole, {"mpc.disturbances=[{late: 0.3, seed: 4}]"});
  expect_holds(loop);
  OrderedJson document = loop_json(loop.run());
  ASSERT_GT(document["late_ticks"].size(), 5u);
  document["late_ticks"].erase(0);
  EXPECT_EQ(failures(judge(loop, document)), "late_ticks;");
  document["late_ticks"] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 9};
  EXPECT_EQ(failures(judge(loop, document)), "clock;late_ticks;");
}

TEST_F(LoopVerdict, FailsIfTheDocumentDisagrees) {
  const SimulatedLoop loop(kBalancedCartpole);
  write(loop);
  const OrderedJson document = loop_json(loop.run());
  const auto failures_of = [&](const char* pointer, const OrderedJson& value) {
    OrderedJson changed = document;
    changed[OrderedJson::json_pointer(pointer)] = value;
    return failures(judge(loop, changed));
  };
  EXPECT_EQ(failures_of("/cost", 1), "plant's cost;cost;");
  EXPECT_EQ(failures_of("/violation", 1), "plant's violation;violation;");
  EXPECT_EQ(failures_of("/end", "stopped"), "plant's way to end;end;");
  EXPECT_EQ(failures_of("/end_time_s", 1.4), "plant's end;end_time_s;");
  EXPECT_EQ(failures_of("/last_state/theta", 3), "plant's last state;last_state/theta;");
  EXPECT_EQ(failures_of("/outcomes/planned", 74), "outcomes/planned;");
  EXPECT_EQ(failures_of("/problem/configuration/mpc/tick", 0.03), "configuration;");
  EXPECT_EQ(failures_of("/problem/name", "other"), "problem/name;");
  const OrderedJson invented = OrderedJson::parse(R"([{"file": "a.urdf", "sha256": ""}])");
  EXPECT_EQ(failures_of("/problem/robots", invented), "problem/robots;");
  EXPECT_EQ(failures_of("/problem/data_files", invented), "problem/data_files;");
  EXPECT_EQ(failures_of("/problem/more", 1), "problem;");
  EXPECT_EQ(failures_of("/more", 1), "document;");
  EXPECT_EQ(failures_of("/clock", "sundial"), "clock;");
}

TEST_F(LoopVerdict, FailsIfTicksAreLateBySimulatedClock) {
  const SimulatedLoop loop(kBalancedCartpole, {}, {10, 11});
  write(loop);
  OrderedJson document = loop_json(loop.run());
  EXPECT_EQ(document["clock"], "wall");
  document["clock"] = "simulated";
  const std::string found = failures(judge(loop, document));
  EXPECT_TRUE(found.starts_with("clock;")) << found;
  EXPECT_NE(found.find("late_ticks;"), std::string::npos) << found;
}

TEST_F(LoopVerdict, ThrowsOnDocumentsNoLoopCanWrite) {
  const SimulatedLoop loop(kBalancedCartpole);
  const OrderedJson document = loop_json(loop.run());
  const auto judge_with = [&](const char* key, const OrderedJson& value) {
    OrderedJson changed = document;
    changed[key] = value;
    return judge(loop, changed);
  };
  EXPECT_THROW(judge_with("tool", 5), MalformedSolution);
  EXPECT_THROW(judge_with("tool", OrderedJson::array()), MalformedSolution);
  EXPECT_THROW(judge_with("clock", 5), MalformedSolution);
  for (const char* ticks : {"[8589934592]", "[-1]", "[75]", "[0.5]", "[18446744073709551615]"})
    EXPECT_THROW(judge_with("late_ticks", OrderedJson::parse(ticks)), MalformedSolution) << ticks;
}

TEST_F(LoopVerdict, NamesTheLineOfAnEmptyState) {
  const SimulatedLoop loop(kBalancedCartpole);
  write(loop);
  replace_text(kPlantFile, with_cell(text(kPlantFile), 42, 4, ""));
  const std::string line = certificate_line(judge(loop, loop_json(loop.run())));
  EXPECT_NE(line.find("line 42: a cell of the state is empty"), std::string::npos) << line;
}

TEST_F(LoopVerdict, ReportsAnEmptyControl) {
  const SimulatedLoop loop(kBalancedCartpole);
  write(loop);
  replace_text(kPlantFile, with_cell(text(kPlantFile), 42, 7, ""));
  const std::string line = certificate_line(judge(loop, loop_json(loop.run())));
  EXPECT_NE(line.find("plant: a number is missing or not finite at 0.205 s"), std::string::npos)
      << line;
}

TEST_F(LoopVerdict, FailsAtTheRowWithAWrongState) {
  const SimulatedLoop loop(kBalancedCartpole);
  write(loop);
  const std::string rows = text(kPlantFile);
  replace_text(kPlantFile, with_cell(rows, 42, 7, "0.5"));  // the control at 0.2 s
  const LoopCertificate control = judge(loop, loop_json(loop.run()));
  EXPECT_NE(failures(control).find("plant;"), std::string::npos);
  EXPECT_NE(certificate_line(control).find("DOES NOT HOLD: plant: is off by "), std::string::npos);
  EXPECT_NE(certificate_line(control).find("at 0.205 s, "), std::string::npos)
      << certificate_line(control);
  replace_text(kPlantFile, with_cell(rows, 42, 4, "3.2"));  // theta
  EXPECT_NE(certificate_line(judge(loop, loop_json(loop.run()))).find("DOES NOT HOLD: plant: "),
            std::string::npos);
}

TEST_F(LoopVerdict, FailsOnTruncatedOrMalformedTables) {
  const SimulatedLoop loop(kBalancedCartpole);
  write(loop);
  const OrderedJson document = loop_json(loop.run());
  const std::string rows = text(kPlantFile), ticks = text(kTicksFile);
  replace_text(kTicksFile, with_cell(ticks, 5, 6, "0.125"));
  EXPECT_EQ(failures(judge(loop, document)), "ticks.csv;");
  replace_text(kTicksFile, ticks);
  replace_text(kPlantFile, rows.substr(0, rows.size() / 2));
  EXPECT_NE(failures(judge(loop, document)).find("plant;"), std::string::npos);
  replace_text(kPlantFile, "t,phase\n");
  EXPECT_EQ(failures(judge(loop, document)), "plant;closed_loop.csv;");
}

TEST_F(LoopVerdict, NamesMissingTables) {
  const SimulatedLoop loop(kBalancedCartpole);
  const LoopCertificate certificate = judge(loop, loop_json(loop.run()));
  EXPECT_TRUE(certificate.checks.holds());
  EXPECT_EQ(certificate.missing, (std::vector<std::string>{"closed_loop.csv", "ticks.csv"}));
}

TEST_F(LoopVerdict, AllowsTheLastDigitsOfAnotherBuild) {
  const SimulatedLoop loop(kBalancedCartpole);
  write(loop);
  OrderedJson document = loop_json(loop.run());
  document["fallback_ticks"] = 0;
  const double cost = document["cost"];
  document["cost"] = cost * (1 + 1e-13);
  EXPECT_EQ(failures(judge(loop, document)), "cost;");
  document["tool"]["revision"] = "another";
  EXPECT_EQ(failures(judge(loop, document)), "");
  document["cost"] = cost * 1.01;
  EXPECT_NE(failures(judge(loop, document)), "");
}

TEST_F(LoopVerdict, ThrowsIfTheDocumentLacksKeys) {
  const SimulatedLoop loop(kBalancedCartpole);
  OrderedJson document = loop_json(loop.run());
  document.erase("ticks");
  EXPECT_THROW(judge(loop, document), MalformedSolution);
}

}  // namespace
}  // namespace conddp
