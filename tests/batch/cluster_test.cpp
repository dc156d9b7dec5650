// Slurm output and submissions.
#include <cstdlib>

#include <gtest/gtest.h>

#include "batch/cluster/array_index.hpp"
#include "batch/cluster/program.hpp"
#include "batch/cluster/slurm_job.hpp"

namespace conddp {
namespace {

TEST(SlurmTime, IsReadAsSlurmPrintsIt) {
  const std::pair<const char*, double> times[] = {
      {"30", 1800},        {"30:00", 1800},        {"1:30", 90},
      {"2:00:05", 7205},   {"1-0", 86400},         {"1-12", 129600},
      {"1-12:30", 131400}, {"2-00:00:07", 172807}, {" 5:00 \n", 300}};
  for (const auto& [text, seconds] : times) EXPECT_EQ(parse_slurm_time(text), seconds) << text;
  for (const char* text : {"UNLIMITED", "infinite", "", "1:2:3:4", "1-", "-3", "a:b", "1:"})
    EXPECT_EQ(parse_slurm_time(text), std::nullopt) << text;
}

TEST(SlurmPartition, TheDefaultOneHasAStar) {
  const char* text = "debug 10:00\ncpu* 2-00:00:00\ngpu 1:00:00\n";
  EXPECT_EQ(parse_partition_time(text, false), 172800);
  EXPECT_EQ(parse_partition_time(text, true), 600);
  EXPECT_EQ(parse_partition_time("long* infinite\n", false), std::nullopt);
  EXPECT_EQ(parse_partition_time("debug 10:00\n", false), std::nullopt);
  EXPECT_EQ(parse_partition_time("", true), std::nullopt);
}

TEST(SlurmConfig, ReportsMaximumArraySizeAndUserLimits) {
  const SlurmLimits limits = parse_slurm_config(
      "Configuration data as of 2026-01-01\n"
      "AccountingStorageType   = accounting_storage/slurmdbd\n"
      "MaxArraySize            = 501\nMaxJobCount             = 10000\n");
  EXPECT_EQ(limits.array_size, 501);
  EXPECT_TRUE(limits.has_accounting);
  EXPECT_FALSE(
      parse_slurm_config("AccountingStorageType = accounting_storage/none\n").has_accounting);
  EXPECT_EQ(parse_slurm_config("nothing").array_size, 1001);
}

TEST(SlurmSubmitLimit, IsTheLeastOverAUsersAccounts) {
  EXPECT_EQ(parse_submit_limit("3\n"), 3);
  EXPECT_EQ(parse_submit_limit("\n20\n3\n\n"), 3);
  EXPECT_EQ(parse_submit_limit("\n\n"), std::nullopt);
  EXPECT_EQ(parse_submit_limit(""), std::nullopt);
  EXPECT_EQ(parse_submit_limit("sacctmgr: error: 5 problems"), std::nullopt);
}

TEST(SlurmShards, TakeTenMinutesEachWithinTheLimits) {
  SlurmLimits limits{.array_size = 100};
  EXPECT_EQ(shards_for(0, 1, limits), 1);
  EXPECT_EQ(shards_for(600, 1, limits), 1);
  EXPECT_EQ(shards_for(601, 1, limits), 2);
  EXPECT_EQ(shards_for(6000, 1, limits), 10);
  EXPECT_EQ(shards_for(6000, 4, limits), 3);
  EXPECT_EQ(shards_for(1e12, 1, limits), 100);
  limits.submitted = 8;  // including the collecting job
  EXPECT_EQ(shards_for(1e12, 1, limits), 7);
  limits.submitted = 1;
  EXPECT_EQ(limits.most_shards(), 1);
}

TEST(SlurmScript, HasOneElementPerShardAndExecsConddp) {
  const SlurmJob job{.name = "my reach",
                     .program = "/opt/conddp",
                     .run = "/data/it's",
                     .shards = 7,
                     .cpus = 2,
                     .partition = "fast",
                     .time_s = 3000,
                     .any_build = true};
  EXPECT_EQ(slurm_array_script(job),
            "#!/bin/bash\n"
            "#SBATCH --job-name=my_reach\n"
            "#SBATCH --output=slurm/%A_%a.log\n"
            "#SBATCH --open-mode=append\n"
            "#SBATCH --partition=fast\n"
            "#SBATCH --array=0-6\n"
            "#SBATCH --cpus-per-task=2\n"
            "#SBATCH --signal=B:USR1@90\n"
            "#SBATCH --requeue\n"
            "#SBATCH --time=0:50:00\n"
            "exec /opt/conddp batch run '/data/it'\\''s' --shard auto/7 -j 2 --any-build\n");
  EXPECT_EQ(slurm_collect_script(job),
            "#!/bin/bash\n"
            "#SBATCH --job-name=my_reach-collect\n"
            "#SBATCH --output=slurm/%j_collect.log\n"
            "#SBATCH --open-mode=append\n"
            "#SBATCH --partition=fast\n"
            "exec /opt/conddp batch collect '/data/it'\\''s'\n");
}

TEST(SlurmScript, HasNoLinesFromNames) {
  EXPECT_EQ(unfit_for_scripts({.run = "/data/it's", .partition = "fast,slow"}), "");
  for (const char* partition : {"fast\n#SBATCH --x", "fast slow", "fast\r"})
    EXPECT_NE(unfit_for_scripts({.partition = partition}), "") << partition;
  EXPECT_NE(unfit_for_scripts({.run = "/data/a\nEND\n"}), "");
  EXPECT_EQ(slurm_array_script({.name = "a\r\n#SBATCH --x"}).find("\n#SBATCH --x"),
            std::string::npos);
}

TEST(SlurmScript, WarnsShortElementsLater) {
  const auto script = [](double seconds) { return slurm_array_script({.time_s = seconds}); };
  EXPECT_NE(script(60).find("USR1@12\n"), std::string::npos);
  EXPECT_NE(script(20).find("USR1@10\n"), std::string::npos);
  EXPECT_NE(script(7200).find("USR1@90\n"), std::string::npos);
  EXPECT_NE(script(7201).find("--time=2:01:00\n"), std::string::npos);
}

/// Job array variables, unset before and after each test.
class ArrayVariables : public testing::Test {
 protected:
  void TearDown() override {
    for (const char* variable : {"SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "PBS_ARRAY_INDEX",
                                 "AWS_BATCH_JOB_ARRAY_INDEX"})
      unsetenv(variable);
  }
  void SetUp() override { TearDown(); }
};

TEST_F(ArrayVariables, ProvideTheIndexInEveryQueueSystem) {
  EXPECT_FALSE(array_index());
  int expected = 4;
  for (const char* variable : {"AWS_BATCH_JOB_ARRAY_INDEX", "PBS_ARRAY_INDEX",
                               "JOB_COMPLETION_INDEX", "SLURM_ARRAY_TASK_ID"}) {
    setenv(variable, std::to_string(--expected).c_str(), 1);
    const auto index = array_index();
    ASSERT_TRUE(index) << variable;
    EXPECT_EQ(index->variable, variable);
    EXPECT_EQ(index->index, expected);
  }
}

TEST_F(ArrayVariables, NonNumericValuesYieldToOtherVariables) {
  for (const char* value : {"", "x", "-1", "1x", "99999999999"}) {
    setenv("PBS_ARRAY_INDEX", value, 1);
    ASSERT_TRUE(array_index()) << value;
    EXPECT_FALSE(array_index()->index) << value;
    EXPECT_EQ(array_index()->variable, "PBS_ARRAY_INDEX");
    EXPECT_EQ(array_index()->text, value);
  }
  setenv("AWS_BATCH_JOB_ARRAY_INDEX", "2", 1);
  EXPECT_EQ(array_index()->index, 2);
}

TEST(Program, ReceivesInputAndReturnsStreamsAndStatus) {
  const ProgramEnd end = run_program({"sh", "-c", "cat; echo wrong >&2; exit 7"}, "hello\n");
  EXPECT_EQ(end.exit_status, 7);
  EXPECT_EQ(end.out, "hello\n");
  EXPECT_EQ(end.err, "wrong\n");
}

TEST(Program, EndsDespiteMuchOutputOnBothStreams) {
  const ProgramEnd end = run_program(
      {"sh", "-c", "head -c 300000 /dev/zero >&2; head -c 200000 /dev/zero"}, "not read");
  EXPECT_EQ(end.exit_status, 0);
  EXPECT_EQ(end.out.size(), 200000u);
  EXPECT_EQ(end.err.size(), 300000u);
}

TEST(Program, ReportsAMissingProgram) {
  const ProgramEnd end = run_program({"conddp_has_no_such_program"});
  EXPECT_EQ(end.exit_status, -1);
  EXPECT_NE(end.err.find("'conddp_has_no_such_program' cannot be started: "), std::string::npos);
}

TEST(Program, HasNoStatusAfterASignal) {
  EXPECT_EQ(run_program({"sh", "-c", "kill -9 $$"}).exit_status, -1);
}

}  // namespace
}  // namespace conddp
