// conddp batch as a process: results match the undisturbed run whatever happens.
#include <algorithm>
#include <csignal>
#include <fstream>
#include <random>
#include <sstream>

#include "batch_fixture.hpp"

namespace conddp {
namespace {

TEST_F(Batch, SingleCommandMatchesSeparateSteps) {
  const std::string expected = this->expected();
  EXPECT_EQ(std::count(expected.begin(), expected.end(), '\n'), 31);
  const std::string run = folder_.path() / "all";
  const ProcessResult r = run_conddp({"batch", "run", plan(), "-o", run, "-j", "2"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("30 of 30 items have a result, 30 of them solved"), std::string::npos)
      << r.out;
  EXPECT_EQ(read_file(std::filesystem::path(run) / "results.csv"), expected);
  EXPECT_EQ(run_conddp({"batch", "status", run}).exit_code, 0);
}

TEST_F(Batch, ResultsIgnoreShardsWorkersAndGroups) {
  const std::string expected = this->expected();
  int number = 0;
  for (const int shards : {1, 3, 7})
    for (const char* workers : {"1", "2"})
      for (const char* group : {"1", "8"}) {
        const std::string folder = planned("run" + std::to_string(++number));
        for (int i = shards; i >= 1; --i) {
          const ProcessResult r = run(folder, {"-j", workers, "--group", group, "--shard",
                                               std::to_string(i) + "/" + std::to_string(shards)});
          EXPECT_EQ(r.exit_code, 0) << r.err;
        }
        EXPECT_EQ(collected(folder), expected) << shards << " " << workers << " " << group;
      }
}

TEST_F(Batch, KilledAndResumedRunsGiveTheSameResults) {
  const std::string expected = this->expected();
  const std::string folder = planned("killed");
  std::mt19937 engine(31);
  for (int i = 0; i < 50; ++i) {
    const int microseconds = static_cast<int>(engine() % 60'000);
    const ProcessResult r = run(folder, {"-j", "2", "--group", i % 2 == 0 ? "1" : "8"},
                                {.kill_after_us = microseconds});
    EXPECT_TRUE(r.exit_code == 128 + SIGKILL || r.exit_code == 0) << r.exit_code << r.err;
  }
  EXPECT_EQ(run(folder).exit_code, 0);
  EXPECT_EQ(collected(folder), expected);
}

TEST_F(Batch, ReportsWriteErrorsWithoutLoss) {
  const std::string expected = this->expected();
  const std::string folder = planned("full");
  for (const int limit : {0, 500, 5000, 9000}) {
    const ProcessResult r = run(folder, {}, {.limit_file_size = limit});
    EXPECT_EQ(r.exit_code, 2) << limit;
    EXPECT_NE(r.err.find("cannot be written"), std::string::npos) << r.err;
  }
  EXPECT_EQ(run(folder).exit_code, 0);
  EXPECT_EQ(collected(folder), expected);
}

TEST_F(Batch, SecondRunHasNothingToDo) {
  const std::string folder = planned("twice");
  EXPECT_EQ(run(folder).exit_code, 0);
  const std::string lines = read_file(folder + "/shards/1of1.jsonl");
  const ProcessResult r = run(folder);
  EXPECT_EQ(r.exit_code, 0);
  EXPECT_EQ(r.out, "30 of 30 items have a result, 30 of them solved\n");
  EXPECT_EQ(read_file(folder + "/shards/1of1.jsonl"), lines);
}

TEST_F(Batch, RecordsCrashesHangsAndMemoryLimits) {
  const std::string rest =
      std::string(kAxes) + "limits: {max_time_s: 0.4, max_memory_mb: 2000, retries: 1}\n";
  const std::pair<const char*, const char*> faults[] = {
      {"crash", "crashed,0"}, {"hang", "killed,0"}, {"memory", "out_of_memory,0"}};
  for (const auto& [fault, status] : faults) {
    const std::string folder = planned(fault, rest);
    const std::string id = ids(folder)[11];
    const std::string variable = std::string("CONDDP_BATCH_FAULT=") + fault + ":" + id;
    const ProcessResult r = run(folder, {"-j", "2"}, {.environment = {variable}});
    EXPECT_EQ(r.exit_code, 1) << r.err;
    EXPECT_NE(r.out.find("30 of 30 items have a result, 29 of them solved"), std::string::npos)
        << fault << r.out;
    const std::string results = collected(folder);
    const std::size_t row = results.find(id);
    EXPECT_NE(results.substr(row, results.find('\n', row) - row).find(status), std::string::npos)
        << results.substr(row, 200);
    const ProcessResult again = run_conddp({"batch", "retry", folder, "failed"});
    EXPECT_EQ(again.exit_code, 0) << again.err << again.out;
    EXPECT_NE(again.out.find("results.csv' is older than these results: 'conddp batch collect'"),
              std::string::npos)
        << again.out;
    EXPECT_EQ(run(folder).out.find("older"), std::string::npos);
    EXPECT_EQ(run_conddp({"batch", "status", folder}).exit_code, 0);
  }
}

TEST_F(Batch, SignalEndsItWithItsExitStatus) {
  const std::string folder = planned("signal", std::string(kAxes) + "limits: {max_time_s: 60}\n");
  const std::string variable = "CONDDP_BATCH_FAULT=hang:" + ids(folder)[29];
  // The hanging worker announces itself beforehand.
  const ProcessResult r = run(
      folder, {"-j", "1"}, {.environment = {variable}, .signal = SIGTERM, .signal_after = "hang"});
  EXPECT_EQ(r.exit_code, 128 + SIGTERM) << r.err;
  EXPECT_EQ(run(folder).exit_code, 0);
}

TEST_F(Batch, BudgetStopsItBeforeTheEnd) {
  const std::string folder = planned("budget");
  const ProcessResult r = run(folder, {"-j", "1", "--budget", "0.001s"});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_EQ(run_conddp({"batch", "status", folder}).exit_code, 1);
  EXPECT_EQ(run(folder).exit_code, 0);
}

TEST_F(Batch, ShardTakesItsIndexFromTheJobArray) {
  const std::string expected = this->expected();
  const std::string folder = folder_.path() / "array";
  ASSERT_EQ(run_conddp({"batch", "plan", plan(), "-o", folder, "--shards", "3"}).exit_code, 0);
  for (const char* index : {"JOB_COMPLETION_INDEX=2", "PBS_ARRAY_INDEX=0"})
    EXPECT_EQ(run(folder, {"--shard", "auto"}, {.environment = {index}}).exit_code, 0) << index;
  EXPECT_EQ(
      run(folder, {"--shard", "auto/3"}, {.environment = {"SLURM_ARRAY_TASK_ID=1"}}).exit_code, 0);
  EXPECT_EQ(collected(folder), expected);
  for (const char* shard : {"1of3", "2of3", "3of3"})
    EXPECT_FALSE(read_file(folder + "/shards/" + shard + ".jsonl").empty()) << shard;
}

TEST_F(Batch, RejectsShardsWithoutIndexOrOutOfRange) {
  const std::string folder = planned("array");
  const ProcessResult none = run(folder, {"--shard", "auto/3"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.err.find("is not part of a job array"), std::string::npos) << none.err;
  const ProcessResult beyond =
      run(folder, {"--shard", "auto/3"}, {.environment = {"AWS_BATCH_JOB_ARRAY_INDEX=3"}});
  EXPECT_EQ(beyond.exit_code, 2);
  EXPECT_NE(beyond.err.find("AWS_BATCH_JOB_ARRAY_INDEX is 3, and there are 3 shards"),
            std::string::npos)
      << beyond.err;
  for (const char* shard : {"4/3", "auto/0", "auto/", "/3", "1/2/3", "auto3"})
    EXPECT_EQ(run(folder, {"--shard", shard}).exit_code, 2) << shard;
}

TEST_F(Batch, RejectsOptionsThatAnActionIgnores) {
  const std::string folder = planned("options");
  const std::pair<Words, const char*> cases[] = {
      {{"run", folder, "--dry-run"}, "'run' has no --dry-run"},
      {{"plan", folder, "--partition", "p"}, "'plan' has no --partition"},
      {{"retry", folder, "failed", "--time", "5m"}, "'retry' has no --time"},
      {{"status", folder, "--shards", "3"}, "'status' has no --shards"},
      {{"status", folder, "-j", "3"}, "'status' has no -j"},
      {{"collect", folder, "-o", "x"}, "'collect' has no -o"},
      {{"run", folder, "--pilot", "3"}, "'run' has no --pilot"},
      {{"plan", folder, "--shard", "1/2"}, "'plan' has no --shard"},
      {{"plan", folder, "--budget", "5s"}, "'plan' has no --budget"},
      {{"submit", folder, "--group", "3"}, "'submit' has no --group"},
      {{"show", folder, "x", "--any-build"}, "'show' has no --any-build"},
      {{"run", folder, "-o", "elsewhere"}, "a run stays in its folder"},
      {{"submit", folder, "--time", "1e300h"}, "'1e300h' is not a time"},
      {{"run", folder, "--shards", "3"}, "the plan of this run fixes the number of shards"}};
  for (const auto& [words, message] : cases) {
    Words all = {"batch"};
    all.insert(all.end(), words.begin(), words.end());
    const ProcessResult r = run_conddp(all);
    EXPECT_EQ(r.exit_code, 2) << message;
    EXPECT_NE(r.err.find(message), std::string::npos) << r.err;
  }
  EXPECT_FALSE(std::filesystem::exists(folder + "/shards"));
}

TEST_F(Batch, ShardIsRetriedByItself) {
  const std::string folder = planned("retry");
  const std::string variable = "CONDDP_BATCH_FAULT=crash:" + ids(folder)[4];
  EXPECT_EQ(run(folder, {}, {.environment = {variable}}).exit_code, 1);
  const ProcessResult other = run_conddp({"batch", "retry", folder, "failed", "--shard", "1/2"});
  EXPECT_EQ(run_conddp({"batch", "status", folder}).exit_code, 0) << other.err;
  EXPECT_TRUE(std::filesystem::exists(folder + "/shards/1of2.jsonl"));
}

/// Hides the Slurm programs of this machine.
const ProcessOptions kWithoutCluster = {.environment = {"PATH=/nowhere"}};

TEST_F(Batch, DryRunSizesTheArrayByPilotTimes) {
  const std::string folder = planned("cluster");
  const ProcessResult unknown =
      run_conddp({"batch", "submit", folder, "--dry-run"}, kWithoutCluster);
  EXPECT_EQ(unknown.exit_code, 2);
  EXPECT_NE(unknown.err.find("the time per item is not known yet"), std::string::npos)
      << unknown.err;
  EXPECT_EQ(run_conddp({"batch", "plan", plan(), "-o", folder, "--pilot", "2"}).exit_code, 0);
  const ProcessResult r =
      run_conddp({"batch", "submit", folder, "--dry-run", "-j", "3"}, kWithoutCluster);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("#SBATCH --array=0-0\n"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("--shard auto/1 -j 3\n"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("#SBATCH --time=0:10:00\n"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("--dependency=afterany:ARRAY"), std::string::npos) << r.out;
  EXPECT_FALSE(std::filesystem::exists(folder + "/slurm"));
}

TEST_F(Batch, SubmittingWithoutAClusterIsAnError) {
  const ProcessResult r =
      run_conddp({"batch", "submit", planned("cluster"), "--shards", "2"}, kWithoutCluster);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("there is no Slurm cluster here"), std::string::npos) << r.err;
}

TEST_F(Batch, NeighbourWarmStartsDependOnlyOnThePlan) {
  const std::string rest = R"(vary:
  goal: {key: terminal.costs.goal.reference.values.theta, linspace: [0.5, 2.5, 40]}
  draw: {perturb: initial_state, spread: 0.2, count: 2}
warm_start: neighbour
)";
  const std::string undisturbed = planned("undisturbed", rest);
  EXPECT_EQ(run(undisturbed, {"-j", "1"}).exit_code, 0);
  const std::string expected = collected(undisturbed);
  EXPECT_GT(std::count(expected.begin(), expected.end(), '\n'), 80);
  EXPECT_NE(expected.find(",warm,"), std::string::npos) << expected.substr(0, 500);
  // Solutions record their start.
  const std::string parent = "the answer of item " + ids(undisturbed)[0];
  EXPECT_NE(read_file(undisturbed + "/shards/1of1.solutions").find(parent), std::string::npos);
  int number = 0;
  for (const int shards : {1, 3})
    for (const int kill_after_us : {60'000, 120'000}) {
      const std::string folder = planned("run" + std::to_string(++number), rest);
      for (int i = shards; i >= 1; --i) {
        const Words words = {"-j", "2", "--shard",
                             std::to_string(i) + "/" + std::to_string(shards)};
        run(folder, words, {.kill_after_us = kill_after_us});
        EXPECT_EQ(run(folder, words).exit_code, 0);
      }
      EXPECT_EQ(collected(folder), expected) << shards << " " << kill_after_us;
    }
}

TEST_F(Batch, ItemWithFailedParentUsesItsOwnGuess) {
  const std::string rest = R"(vary:
  goal: {key: terminal.costs.goal.reference.values.theta, linspace: [0.5, 2.5, 5]}
warm_start: neighbour
)";
  const std::string folder = planned("failed", rest);
  const std::string variable = "CONDDP_BATCH_FAULT=crash:" + ids(folder)[2];
  EXPECT_EQ(run(folder, {}, {.environment = {variable}}).exit_code, 1);
  std::istringstream rows(collected(folder));
  std::string row, starts;
  std::getline(rows, row);
  while (std::getline(rows, row))
    starts += row.find(",warm,") != row.npos ? 'w' : row.find(",own,") != row.npos ? 'o' : '-';
  EXPECT_EQ(starts, "ow-ow");
}

constexpr const char* kLongBlock = R"(vary:
  goal: {key: terminal.costs.goal.reference.values.theta, linspace: [0.5, 2.5, 20]}
warm_start: neighbour
limits: {max_time_s: 0.4}
)";

// Each item has its own time limit, although a fresh process solves its ancestors again.
TEST_F(Batch, PilotDoesNotAffectNeighbourWarmStarts) {
  const std::string undisturbed = planned("undisturbed", kLongBlock);
  EXPECT_EQ(run(undisturbed).exit_code, 0);
  const std::string expected = collected(undisturbed), folder = folder_.path() / "pilot";
  const ProcessOptions slowly = {.environment = {"CONDDP_BATCH_FAULT=slow:250"}};
  const ProcessResult pilot = run_conddp(
      {"batch", "plan", plan(kLongBlock), "-o", folder, "--pilot", "2", "-j", "1"}, slowly);
  EXPECT_EQ(pilot.exit_code, 0) << pilot.err << pilot.out;
  EXPECT_EQ(run(folder).exit_code, 0);
  EXPECT_EQ(collected(folder), expected);
}

TEST_F(Batch, RetriedParentProvidesStartsForItsChildren) {
  const std::string undisturbed = planned("undisturbed", kLongBlock);
  EXPECT_EQ(run(undisturbed).exit_code, 0);
  const std::string expected = collected(undisturbed), folder = planned("crash", kLongBlock);
  const std::string variable = "CONDDP_BATCH_FAULT=crash:" + ids(folder)[4];
  EXPECT_EQ(run(folder, {}, {.environment = {variable}}).exit_code, 1);
  EXPECT_NE(collected(folder), expected);
  const ProcessResult r = run_conddp({"batch", "retry", folder, "failed", "-j", "2"});
  EXPECT_EQ(r.exit_code, 0) << r.err << r.out;
  EXPECT_EQ(collected(folder), expected);
}

TEST_F(Batch, ParentCrashIsNotChargedToItsChild) {
  const std::string folder = folder_.path() / "again";
  ASSERT_EQ(run_conddp({"batch", "plan", plan(kLongBlock), "-o", folder}).exit_code, 0);
  const std::string variable = "CONDDP_BATCH_FAULT=crash:" + ids(folder)[4];
  // The crashing item is outside the pilot.
  const ProcessResult pilot =
      run_conddp({"batch", "plan", plan(kLongBlock), "-o", folder, "--pilot", "2", "-j", "1"},
                 {.environment = {variable}});
  EXPECT_EQ(pilot.exit_code, 0) << pilot.err << pilot.out;
  EXPECT_NE(pilot.out.find("pilot: 2 of 2 solved"), std::string::npos) << pilot.out;
  // Afterwards it is recorded on its own, as in a run without a pilot.
  EXPECT_EQ(run(folder, {}, {.environment = {variable}}).exit_code, 1);
  const std::string without = planned("without", kLongBlock);
  EXPECT_EQ(run(without, {}, {.environment = {variable}}).exit_code, 1);
  EXPECT_EQ(collected(folder), collected(without));
}

/// A cluster of stubs. `fails`: words of the sbatch call that fails.
ProcessOptions stub_cluster(const TemporaryFolder& folder, const std::string& fails = "none") {
  const auto program = [&](const char* name, const std::string& text) {
    const std::filesystem::path file =
        folder.write(std::string("stub/") + name, "#!/bin/sh\n" + text);
    std::filesystem::permissions(file, std::filesystem::perms::owner_all);
    return file.parent_path().string();
  };
  program("scontrol", "echo 'MaxArraySize = 1001'\n");
  program("sinfo", "echo 'debug 10:00'; echo 'cpu* 2-00:00:00'\n");
  const std::string path = program("sbatch", "cat > /dev/null\ncase \"$*\" in *" + fails +
                                                 "*) echo no >&2; exit 1;; esac\necho 77\n");
  return {.environment = {"PATH=" + path + ":/usr/bin:/bin"}};
}

TEST_F(Batch, SubmitUsesTheLimitOfTheDefaultPartition) {
  const std::string folder = planned("submit");
  const Words words = {"batch", "submit", folder, "--shards", "2", "--time"};
  const auto submit = [&](const char* time) {
    Words all = words;
    all.emplace_back(time);
    return run_conddp(all, stub_cluster(folder_));
  };
  const ProcessResult r = submit("30h");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out, "job 77: 2 shards; job 77 collects\n");
  EXPECT_NE(submit("50h").err.find("this partition ends jobs after 2880 min"), std::string::npos);
  EXPECT_NE(submit("10").err.find("'10' has no unit: write 10m or 10s"), std::string::npos);
  for (const char* none : {"1:2:3:4", "0:00:00", "infinite", "1-"})
    EXPECT_NE(submit(none).err.find("such as 10m, 1h30m or 1:30:00"), std::string::npos) << none;
  for (const char* time : {"90m", "1:30:00", "90:00"}) {
    std::filesystem::remove_all(folder + "/slurm");
    EXPECT_EQ(submit(time).exit_code, 0) << time;
    EXPECT_NE(read_file(folder + "/slurm/array.sh").find("#SBATCH --time=1:30:00\n"),
              std::string::npos)
        << time;
  }
}

TEST_F(Batch, SubmitUsesTheShardsOfThePlan) {
  const std::string folder = folder_.path() / "shards";
  ASSERT_EQ(run_conddp({"batch", "plan", plan(), "-o", folder, "--shards", "5"}).exit_code, 0);
  const ProcessResult r = run_conddp({"batch", "submit", folder}, stub_cluster(folder_));
  EXPECT_EQ(r.out, "job 77: 5 shards; job 77 collects\n") << r.err;
}

TEST_F(Batch, StatusOfAPlanNamesItsRun) {
  const std::string file = plan();
  const ProcessResult r = run_conddp({"batch", "status", file});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.err.find("conddp: error: '" + file + "' is a file, not the folder of a run\n"), 0u)
      << r.err;
  EXPECT_NE(r.err.find("in out/ and the plan's name"), std::string::npos) << r.err;
}

TEST_F(Batch, SubmitNamesQueuedJobIfSecondIsRejected) {
  const ProcessResult r = run_conddp({"batch", "submit", planned("submit"), "--shards", "2"},
                                     stub_cluster(folder_, "afterany"));
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("the shards are queued already as job 77"), std::string::npos) << r.err;
}

TEST_F(Batch, CompletedRunIsNotSubmitted) {
  const std::string folder = planned("submit");
  EXPECT_EQ(run(folder).exit_code, 0);
  const ProcessResult r = run_conddp({"batch", "submit", folder}, stub_cluster(folder_));
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out, "all items have a result: nothing is submitted\n");
  EXPECT_FALSE(std::filesystem::exists(folder + "/slurm"));
}

TEST_F(Batch, AllItemsMayStartFromOneSolution) {
  const std::string solution = folder_.path() / "former";
  ASSERT_EQ(run_conddp({"solve", folder_.path() / "swing.yaml", "-o", solution}).exit_code, 0);
  const std::string folder = planned("from_file",
                                     "vary: {w: {key: costs.effort.weight, values: [0.5, 0.6]}}\n"
                                     "warm_start: former/solution.json\n");
  EXPECT_EQ(run(folder).exit_code, 0);
  const std::string cold =
      planned("cold", "vary: {w: {key: costs.effort.weight, values: [0.5, 0.6]}}\n");
  EXPECT_EQ(run(cold).exit_code, 0);
  // The first item already has its answer.
  EXPECT_NE(collected(folder), collected(cold));
  EXPECT_NE(collected(folder).find(",box_ddp,converged,1,warm,"), std::string::npos)
      << collected(folder);
}

/// A column of a results.csv without quotes before it.
std::vector<std::string> column(const std::string& table, const std::string& name) {
  std::istringstream lines(table);
  std::vector<std::string> cells;
  std::size_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::vector<std::string> row;
    for (std::string word; std::getline(words, word, ',');) row.push_back(word);
    if (cells.empty()) number = std::find(row.begin(), row.end(), name) - row.begin();
    cells.push_back(row.at(number));
  }
  cells.erase(cells.begin());
  return cells;
}

constexpr const char* kLimited = R"(conddp: 1
system: {type: double_integrator}
initial_state: {state: [0, 0]}
integrator: rk4
phases: [{name: move, knots: 20, dt: 0.1}]
costs:
  effort: {residual: control, weight: 0.1}
  state: {residual: state, reference: [1, 0]}
constraints:
  speed: {bounds: velocity, lower: -0.6, upper: 0.6}
terminal:
  constraints:
    goal: {residual: state, reference: [1, 0]}
solver: {name: altro}
)";

TEST_F(Batch, StartFromAFileHasMultipliersLikeSolve) {
  folder_.write("swing.yaml", kLimited);
  const std::string former = folder_.path() / "former", again = folder_.path() / "again";
  ASSERT_EQ(run_conddp({"solve", folder_.path() / "swing.yaml", "-o", former}).exit_code, 0);
  ASSERT_EQ(run_conddp({"solve", folder_.path() / "swing.yaml", "--warm-start",
                        former + "/solution.json", "-o", again})
                .exit_code,
            0);
  const std::string folder = planned("from_file", "warm_start: former/solution.json\n");
  EXPECT_EQ(run(folder).exit_code, 0);
  const auto solved = nlohmann::json::parse(read_file(again + "/solution.json"));
  EXPECT_EQ(column(collected(folder), "iterations"), Words{solved["iterations"].dump()});
  EXPECT_EQ(column(collected(folder), "warm_start"), Words{"warm"});
  const std::string shown = folder_.path() / "item";
  EXPECT_EQ(
      run_conddp({"batch", "show", folder, ids(folder)[0].substr(0, 4), "-o", shown}).exit_code, 0);
  const auto item = nlohmann::json::parse(read_file(shown + "/solution.json"));
  EXPECT_EQ(item["initial_guess_used"]["multipliers"], solved["initial_guess_used"]["multipliers"]);
  EXPECT_EQ(run_conddp({"verify", shown + "/solution.json"}).exit_code, 0);

  std::ofstream(former + "/solution.json", std::ios::app) << '\n';
  const ProcessResult r = run(folder);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("solution.json', which items read, has changed"), std::string::npos)
      << r.err;
}

// On the grid of the file, a replay of the controls ends elsewhere.
constexpr const char* kMeshed = R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.1}}
integrator: explicit_euler
phases: [{name: swing, knots: 4, duration: 1}]
costs: {effort: {residual: control, weight: 0.5}}
terminal:
  costs: {goal: {residual: state, reference: {values: {theta: 1}}, weight: 10}}
solver: {name: fddp}
mesh: {error: 0.02}
)";

TEST_F(Batch, RefinesGridsLikeSolve) {
  folder_.write("swing.yaml", kMeshed);
  const std::string former = folder_.path() / "former";
  ASSERT_EQ(run_conddp({"solve", folder_.path() / "swing.yaml", "-o", former}).exit_code, 0);
  const auto solved = nlohmann::json::parse(read_file(former + "/solution.json"));
  ASSERT_GT(solved["mesh"]["rounds"].size(), 1u);

  const std::string folder =
      planned("refined", "vary: {e: {key: mesh.error, values: [0.02, 1]}}\n");
  EXPECT_EQ(run(folder).exit_code, 0);
  EXPECT_EQ(column(collected(folder), "cost")[0], solved["cost"].dump());
  const std::string shown = folder_.path() / "item";
  EXPECT_EQ(run_conddp({"batch", "show", folder, ids(folder)[0], "-o", shown}).exit_code, 0);
  const auto item = nlohmann::json::parse(read_file(shown + "/solution.json"));
  EXPECT_EQ(item["mesh"]["rounds"].size(), solved["mesh"]["rounds"].size());
  EXPECT_EQ(item["trajectory"]["x"], solved["trajectory"]["x"]);
  EXPECT_EQ(run_conddp({"verify", shown + "/solution.json"}).exit_code, 0);

  const std::string coarse =
      planned("coarse", "vary: {e: {key: mesh.error, values: [1.0e-12]}}\nwarm_start: neighbour\n");
  EXPECT_EQ(run(coarse).exit_code, 1);
  const std::string results = collected(coarse);
  EXPECT_EQ(column(results, "solved"), Words{"0"});
  EXPECT_NE(results.find("the last grid of 10000 knots has an error of "), std::string::npos)
      << results;
}

constexpr const char* kBalance = R"(conddp: 1
system: {type: cartpole}
initial_state: {values: {theta: 3}}
integrator: rk4
phases: [{name: balance, knots: 20, dt: 0.05}]
costs:
  state:
    residual: state
    reference: {values: {theta: 3.141592653589793}}
    weights: {x: 1, theta: 10, "*": 0.1}
  effort: {residual: control, weight: 0.1}
constraints:
  force: {bounds: control, lower: -10, upper: 5}
terminal:
  costs:
    upright: {residual: state, reference: {values: {theta: 3.141592653589793}}, weight: 20}
solver: {name: box_fddp}
)";

// A pendulum swinging through the bottom is a poor start for one that stands nearly upright.
TEST_F(Batch, DropsMisleadingStartFromAFile) {
  folder_.write("swing.yaml", kBalance);
  ASSERT_EQ(run_conddp({"solve", folder_.path() / "swing.yaml", "--set",
                        "initial_state.values.theta=2.4", "-o", folder_.path() / "former"})
                .exit_code,
            0);
  const std::string warm = planned("warm", "warm_start: former/solution.json\n"),
                    cold = planned("cold", "");
  EXPECT_EQ(run(warm).exit_code, 0);
  EXPECT_EQ(run(cold).exit_code, 0);
  EXPECT_EQ(column(collected(warm), "warm_start"), Words{"dropped"});
  EXPECT_EQ(column(collected(warm), "cost"), column(collected(cold), "cost"));
}

TEST_F(Batch, PilotSolvesFewItemsAndEstimatesTheRest) {
  const std::string folder = folder_.path() / "pilot";
  const ProcessResult r = run_conddp({"batch", "plan", plan(), "-o", folder, "--pilot", "3"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("pilot: 3 of 3 solved; all 30 items take about"), std::string::npos)
      << r.out;
  const ProcessResult all = run(folder);
  EXPECT_NE(all.out.find("; 27 in "), std::string::npos) << all.out;
}

TEST_F(Batch, DoesNotMixInChangedProblemsOrBuilds) {
  const std::string folder = planned("changed");
  std::string changed = kBatchSwing;
  changed.replace(changed.find("weight: 10"), 10, "weight: 11");
  folder_.write("swing.yaml", changed);
  const ProcessResult r = run(folder);
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("has changed since the plan was made"), std::string::npos) << r.err;

  folder_.write("swing.yaml", kBatchSwing);
  std::string manifest = read_file(folder + "/manifest.jsonl");
  const std::size_t at = manifest.find("\"compiler\":\"");
  manifest.insert(at + 12, "other ");
  folder_.write("changed/manifest.jsonl", manifest);
  const ProcessResult other = run(folder);
  EXPECT_EQ(other.exit_code, 2);
  EXPECT_NE(other.err.find("another build of conddp"), std::string::npos) << other.err;
  EXPECT_EQ(run(folder, {"--any-build"}).exit_code, 0);
  std::filesystem::remove(folder_.path() / "swing.yaml");
  const ProcessResult lost = run(folder, {"--any-build"});
  EXPECT_EQ(lost.exit_code, 2);
  EXPECT_NE(lost.err.find("a run has the paths of its problems relative to its folder"),
            std::string::npos)
      << lost.err;
}

TEST_F(Batch, RejectsBadStdinPlansShardsAndTimes) {
  const std::string folder = planned("words");
  const ProcessResult stdin_plan = run_conddp({"batch", "run", "-"});
  EXPECT_EQ(stdin_plan.exit_code, 2);
  EXPECT_NE(stdin_plan.err.find("a plan cannot be read from stdin"), std::string::npos)
      << stdin_plan.err;
  const ProcessResult index =
      run(folder, {"--shard", "auto/2"}, {.environment = {"SLURM_ARRAY_TASK_ID=abc"}});
  EXPECT_EQ(index.exit_code, 2);
  EXPECT_NE(index.err.find("SLURM_ARRAY_TASK_ID is 'abc', which is not an index"),
            std::string::npos)
      << index.err;
  for (const char* time : {"0", "-5", "1h30", "30m1h", "h", "1e12", "2d"}) {
    const ProcessResult r = run(folder, {std::string("--budget=") + time});
    EXPECT_EQ(r.exit_code, 2) << time;
    EXPECT_NE(r.err.find("such as 90s, 55m or 1h30m"), std::string::npos) << r.err;
  }
  const ProcessResult bare = run(folder, {"--budget", "55"});
  EXPECT_EQ(bare.exit_code, 2);
  EXPECT_NE(bare.err.find("'55' has no unit: write 55m or 55s"), std::string::npos) << bare.err;
  const ProcessResult r = run(folder, {"--budget", "1h30m5s", "-j", "2"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("limits the time of an item"), std::string::npos) << r.err;
  EXPECT_EQ(run(folder).err, "");
}

TEST_F(Batch, LeavesResultsOfAnotherPlanAlone) {
  const std::string folder = planned("other");
  EXPECT_EQ(run(folder).exit_code, 0);
  const ProcessResult r =
      run_conddp({"batch", "plan", plan("vary: {w: {key: costs.effort.weight, values: [1]}}\n"),
                  "-o", folder});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("has results of another plan"), std::string::npos) << r.err;
  EXPECT_EQ(run_conddp({"batch", "plan", plan(), "-o", folder}).exit_code, 0);
}

TEST_F(Batch, ReportsBadPlansAndRunsWithPlaces) {
  const std::string wrong = plan("vary: {w: {key: costs.effort.weight, values: [1, -1]}}\n");
  const ProcessResult r = run_conddp({"batch", "plan", wrong, "-o", folder_.path() / "none"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("plan.yaml:4:50: error: a number that is not negative"), std::string::npos)
      << r.err;
  EXPECT_NE(r.err.find("item 2 of 2"), std::string::npos) << r.err;
  EXPECT_EQ(run_conddp({"batch", "status", folder_.path()}).exit_code, 2);
  EXPECT_EQ(run_conddp({"batch", "run", folder_.path() / "missing.yaml"}).exit_code, 2);
  EXPECT_EQ(run_conddp({"batch", "retry", planned("r"), "all"}).exit_code, 2);
  EXPECT_EQ(run_conddp({"batch", "run", planned("s"), "--shard", "3/2"}).exit_code, 2);
}

}  // namespace
}  // namespace conddp
