// Batches of closed loops.
#include <algorithm>

#include "batch_fixture.hpp"
#include "support/balanced_cartpole.hpp"

namespace conddp {
namespace {

const std::string kLoop = std::string("conddp: 1\n") + kBalancing + R"(mpc:
  horizon: 1
  tick: 0.02
  duration: 1.5
  disturbances: [{at: 0.5, jump: {omega: 1}}, {noise: state, sigma: 0.001, seed: 1}]
  stop_when: {fallen: {residual: state, columns: theta, lower: 2.1, upper: 4.2}}
)";

constexpr const char* kPushes = R"(command: mpc
vary:
  push: {key: mpc.disturbances.0.jump.omega, values: [0.5, 20]}
  seed: {key: mpc.disturbances.1.seed, linspace: [1, 2, 2]}
  pole: {key: mpc.plant.set, values: [{system.pole_mass: 0.2}]}
)";

class LoopBatch : public Batch {
 protected:
  LoopBatch() { folder_.write("swing.yaml", kLoop); }
};

TEST_F(LoopBatch, ReportsWhichLoopsLast) {
  const std::string one = planned("one", kPushes), other = planned("other", kPushes);
  const ProcessResult ran = run(one, {"-j", "1"});
  EXPECT_EQ(ran.exit_code, 1) << ran.err;  // two of them fell
  EXPECT_NE(ran.out.find("4 of 4 items have a result, 2 of them survived"), std::string::npos)
      << ran.out;
  for (const char* shard : {"2/2", "1/2"}) run(other, {"--shard", shard});
  const std::string table = collected(one);
  EXPECT_EQ(table, collected(other));
  std::istringstream lines(table);
  std::string line;
  std::getline(lines, line);
  EXPECT_EQ(line,
            "item,id,problem,push,seed,pole,solver,status,survived,time_s,planned,fallback,cost,"
            "violation,message");
  for (const char* words :
       {",box_fddp,finished,1,1.5,1.0,0.0,", ",box_fddp,finished,1,1.5,1.0,0.0,",
        ",box_fddp,stopped,0,", ",box_fddp,stopped,0,"}) {
    std::getline(lines, line);
    EXPECT_NE(line.find(words), std::string::npos) << line;
  }
  EXPECT_NE(line.find(",the condition 'fallen' of stop_when does not hold"), std::string::npos)
      << line;
  EXPECT_FALSE(std::filesystem::exists(one + "/dataset.h5"));
  const ProcessResult status = run_conddp({"batch", "status", one});
  EXPECT_EQ(status.exit_code, 1);
  EXPECT_NE(status.out.find("4 items, 2 survived, 0 unfinished\n  finished            2\n"),
            std::string::npos)
      << status.out;
}

// If ticks are solved to tolerances, every solver drives the same loop.
TEST_F(LoopBatch, ComparesSolversWithIpopt) {
  const std::string batch = planned("solvers",
                                    "command: mpc\nsolvers: [box_fddp, ipopt]\nvary: {i: {key: "
                                    "mpc.iterations, values: [tolerances]}}\n");
  EXPECT_EQ(run(batch).exit_code, 0);
  const std::string table = collected(batch);
  for (const char* words : {",box_fddp,finished,1,1.5,1.0,0.0,", ",ipopt,finished,1,1.5,1.0,0.0,"})
    EXPECT_NE(table.find(words), std::string::npos) << table;
}

TEST_F(LoopBatch, ShowsALoopBySimulatingItAgain) {
  const std::string batch = planned("shown", kPushes);
  run(batch);
  const std::string table = collected(batch), id = ids(batch)[2], item = batch + "/items/" + id;
  const ProcessResult shown = run_conddp({"batch", "show", batch, id});
  EXPECT_EQ(shown.exit_code, 0) << shown.err;
  EXPECT_EQ(shown.out.substr(0, id.size() + 10), id + ": stopped\n") << shown.out;
  const auto document = nlohmann::json::parse(read_file(item + "/mpc.json"));
  EXPECT_EQ(document["end"], "stopped");
  EXPECT_NE(table.find(document["cost"].dump()), std::string::npos) << table;
  EXPECT_EQ(run_conddp({"verify", item + "/mpc.json"}).exit_code, 0);
  const ProcessResult again = run_conddp({"mpc", item + "/problem.yaml", "-o", item + "/again"});
  EXPECT_EQ(again.exit_code, 1);
  EXPECT_EQ(read_file(item + "/again/closed_loop.csv"), read_file(item + "/closed_loop.csv"));
}

TEST_F(LoopBatch, DoesNotRetryFallenLoops) {
  const std::string batch = planned("retried", kPushes);
  run(batch);
  const ProcessResult retried = run_conddp({"batch", "retry", batch, "failed"});
  EXPECT_EQ(retried.out, "there is nothing to solve again\n") << retried.err;
}

TEST_F(LoopBatch, EndsLoopsAtTheTimeLimit) {
  const std::string batch =
      planned("slow",
              "command: mpc\nlimits: {max_time_s: 0.001}\nvary: {d: {key: mpc.duration, values: "
              "[1000]}}\n");
  EXPECT_EQ(run(batch).exit_code, 1);
  EXPECT_NE(collected(batch).find(",time_limit,0,"), std::string::npos) << collected(batch);
}

TEST_F(LoopBatch, ShowsHowALoopEndsWithoutTimeLimit) {
  const std::string batch =
      planned("limited",
              "command: mpc\nlimits: {max_time_s: 0.001}\nvary: {d: {key: mpc.duration, values: "
              "[20]}}\n");
  run(batch);
  ASSERT_NE(collected(batch).find(",time_limit,0,"), std::string::npos) << collected(batch);
  const std::string id = ids(batch)[0];
  const ProcessResult shown = run_conddp({"batch", "show", batch, id});
  EXPECT_EQ(shown.out.find(id + ": finished; in the run: time_limit\n"), 0u) << shown.out;
  const auto document = nlohmann::json::parse(read_file(batch + "/items/" + id + "/mpc.json"));
  EXPECT_EQ(document["end"], "finished");
}

TEST_F(LoopBatch, AcceptsPlansWithoutStoredSolutions) {
  planned("kept", std::string(kPushes) + "keep: {solutions: none}\nwarm_start: none\n");
}

}  // namespace
}  // namespace conddp
