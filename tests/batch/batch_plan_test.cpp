// Items of plans and places of their errors.
#include "batch/plan/batch_plan.hpp"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>

#include "analysis/comparison/random_instance.hpp"
#include "batch/plan/neighbours.hpp"
#include "batch/plan/problem_family.hpp"
#include "batch/plan/run_folder.hpp"
#include "batch/results/collect.hpp"
#include "batch/run/run_batch.hpp"
#include "batch_folder.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Strings = std::vector<std::string>;

std::string text_of(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

Strings settings(const PlannedBatch& batch, std::size_t item) {
  return batch.manifest->items.at(item).settings;
}

TEST(BatchPlan, IsProductOfAxesInFileOrder) {
  const PlannedBatch batch(R"(vary:
  w: {key: costs.effort.weight, linspace: [1, 3, 3]}
  theta: {key: initial_state.values.theta, values: [0.1, 0.2]}
solvers: [ilqr, ddp]
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  ASSERT_EQ(batch.manifest->items.size(), 12u);
  EXPECT_EQ(settings(batch, 0), (Strings{"costs.effort.weight=1", "initial_state.values.theta=0.1",
                                         "solver.name=ilqr"}));
  EXPECT_EQ(settings(batch, 1).back(), "solver.name=ddp");
  EXPECT_EQ(settings(batch, 2)[1], "initial_state.values.theta=0.2");
  EXPECT_EQ(settings(batch, 11), (Strings{"costs.effort.weight=3", "initial_state.values.theta=0.2",
                                          "solver.name=ddp"}));
  EXPECT_EQ(batch.manifest->items[11].values, (Strings{"3", "0.2"}));
  std::set<std::string> ids;
  for (const ManifestItem& item : batch.manifest->items) {
    EXPECT_EQ(item.id.size(), 16u);
    ids.insert(item.id);
  }
  EXPECT_EQ(ids.size(), 12u);
}

TEST(BatchPlan, WithoutVariationHasOneItem) {
  const PlannedBatch batch("");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(batch.manifest->items.size(), 1u);
  EXPECT_TRUE(settings(batch, 0).empty());
  EXPECT_EQ(batch.manifest->name, "plan");
}

TEST(BatchPlan, NamesPhasesInKeys) {
  const PlannedBatch batch("vary: {dt: {key: phases.second.dt, values: [0.02, 0.03]}}\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(settings(batch, 1), Strings{"phases.second.dt=0.03"});
}

TEST(BatchPlan, VariesKeysTogetherInPairsAndTables) {
  PlannedBatch batch(R"(vary:
  pairs: {keys: [costs.effort.weight, phases.0.dt], values: [[1.0e-3, 0.1], [2, 0.2]]}
  goals: {file: goals.csv, columns: {angle: terminal.costs.goal.reference.values.theta}}
)");
  batch.folder.write("goals.csv", "name,angle\nup, 1.5\n\ndown,-1.5 \n");
  batch.plan_again();
  ASSERT_TRUE(batch.manifest) << batch.error();
  ASSERT_EQ(batch.manifest->items.size(), 4u);
  EXPECT_EQ(settings(batch, 2), (Strings{"costs.effort.weight=2", "phases.0.dt=0.2",
                                         "terminal.costs.goal.reference.values.theta=1.5"}));
  EXPECT_EQ(batch.manifest->columns[2].name, "angle");
  EXPECT_EQ(batch.manifest->items[0].values, (Strings{"0.001", "0.1", "1.5"}));
}

TEST(BatchPlan, PerturbsLikeTheBenchmark) {
  const PlannedBatch batch(
      "vary: {start: {perturb: initial_state, spread: 0.1, count: 2, seed: 7}}\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(settings(batch, 1), (Strings{"perturbation.initial_state=0.1", "perturbation.seed=8"}));
  Diagnostics out;
  const auto family = ProblemFamily::load(batch.folder.path() / "swing.yaml", {}, out);
  std::vector<Setting> list;
  Diagnostics texts = family->texts();
  for (const std::string& text : settings(batch, 1)) list.push_back(*parse_setting(text, texts));
  const auto instance = family->build(list, texts);
  ASSERT_TRUE(instance) << format_diagnostics(texts, false);
  EXPECT_EQ(instance->problem->initial_state(),
            perturb_initial_state(*family->base().problem, 0.1, 8).initial_state());
}

TEST(BatchPlan, DrawsTheSameNumbersFromTheSameSeed) {
  const std::string axes = R"(vary:
  a: {key: costs.effort.weight, uniform: [1, 2], count: 3, seed: 5}
  b: {key: initial_state.values.theta, normal: [0, 0.1], count: 2, seed: 5}
  c: {sobol: {phases.0.dt: [0.1, 0.2], phases.1.dt: [0.01, 0.02]}, count: 4}
)";
  const PlannedBatch once(axes), twice(axes);
  ASSERT_TRUE(once.manifest) << once.error();
  ASSERT_EQ(once.manifest->items.size(), 24u);
  for (std::size_t i = 0; i < 24; ++i) {
    EXPECT_EQ(once.manifest->items[i].id, twice.manifest->items[i].id);
    const double weight = std::stod(once.manifest->items[i].values[0]);
    EXPECT_TRUE(weight >= 1 && weight < 2) << weight;
  }
}

TEST(BatchPlan, ItemIdIgnoresHowItIsWritten) {
  const PlannedBatch a("vary: {w: {key: costs.effort.weight, values: [0.001, 2]}}\n"),
      b("# a comment\nvary: {other: {key: costs.effort.weight, values: [1.0e-3, 2.0]}}\n",
        "# another\n" + std::string(kSwing)),
      c("vary: {w: {key: costs.effort.weight, values: [0.001, 2]}}\n",
        std::string(kSwing) + "gravity: [0, 0, -9.81]\n"),
      d("vary: {w: {key: costs.effort.weight, values: [0.002, 2]}}\n");
  ASSERT_TRUE(a.manifest && b.manifest && d.manifest) << b.error();
  EXPECT_EQ(a.manifest->items[0].id, b.manifest->items[0].id);
  EXPECT_EQ(a.manifest->items[1].id, b.manifest->items[1].id);
  EXPECT_FALSE(c.manifest);
  EXPECT_NE(a.manifest->items[0].id, d.manifest->items[0].id);
  EXPECT_EQ(a.manifest->items[1].id, d.manifest->items[1].id);
}

TEST(BatchPlan, AnotherProblemGivesOtherItems) {
  std::string changed = kSwing;
  changed.replace(changed.find("weight: 10"), 10, "weight: 11");
  const std::string axes = "vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n";
  const PlannedBatch a(axes), b(axes, changed);
  ASSERT_TRUE(a.manifest && b.manifest);
  EXPECT_NE(a.manifest->items[0].id, b.manifest->items[0].id);
}

TEST(BatchPlan, TakesFilesByPattern) {
  PlannedBatch batch("");
  for (const char* name : {"b.yaml", "a.yaml"})
    batch.folder.write(name, std::string(kSwing) + "name: " + name[0] + "\n");
  batch.file =
      batch.folder.write("all.yaml", "conddp_batch: 1\nproblems: ['?.yaml', swing.yaml]\n");
  batch.plan_again();
  ASSERT_TRUE(batch.manifest) << batch.error();
  ASSERT_EQ(batch.manifest->problems.size(), 3u);
  EXPECT_EQ(batch.manifest->problems[0].file, "../a.yaml");
  EXPECT_EQ(batch.manifest->problems[2].file, "../swing.yaml");
}

TEST(BatchPlan, ManifestSurvivesARoundTrip) {
  const PlannedBatch batch(R"(vary:
  w: {key: costs.effort.weight, values: [1, 2]}
  goal: {key: terminal.costs.goal.reference, values: [{values: {theta: 1}}, {state: [1, 0]}]}
limits: {max_time_s: 2.5, max_memory_mb: 500, retries: 1}
keep: {solutions: none}
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  const std::string head = manifest_head(*batch.manifest);
  std::string text = head + "\n";
  for (const ManifestItem& item : batch.manifest->items) text += manifest_line(item) + "\n";
  batch.folder.write("manifest.jsonl", text);
  Diagnostics out;
  const auto again = load_manifest(batch.folder.path(), true, out);
  ASSERT_TRUE(again) << format_diagnostics(out, false);
  EXPECT_EQ(manifest_head(*again), head);
  ASSERT_EQ(again->items.size(), 4u);
  for (std::size_t i = 0; i < 4; ++i)
    EXPECT_EQ(manifest_line(again->items[i]), manifest_line(batch.manifest->items[i]));
  EXPECT_EQ(again->limits.max_time_s, 2.5);
  EXPECT_EQ(again->items[0].settings.front(), "solver.max_time_s=2.5");

  batch.folder.write("manifest.jsonl", text.substr(0, text.size() - 40));
  Diagnostics damaged;
  EXPECT_FALSE(load_manifest(batch.folder.path(), true, damaged));
  EXPECT_EQ(damaged.list().front().line, 5);
}

struct BadPlan {
  const char* rest;
  const char* error;
};

class BadPlans : public testing::TestWithParam<BadPlan> {};

TEST_P(BadPlans, AreReportedAtTheirPlaces) {
  PlannedBatch batch(GetParam().rest);
  batch.folder.write("goals.csv", "angle,w\n1,0.5\nx,0.5\n2\n");
  batch.plan_again();
  EXPECT_FALSE(batch.manifest);
  EXPECT_EQ(batch.error(), GetParam().error);
}

INSTANTIATE_TEST_SUITE_P(
    Classes, BadPlans,
    testing::Values(
        BadPlan{"vray: {}\n", "plan.yaml:3:1: unknown key 'vray'"},
        BadPlan{"vary: {w: {key: costs.effort.wieght, values: [1]}}\n",
                "plan.yaml:3:30: unknown key 'wieght' in 'costs.effort'"},
        BadPlan{"vary: {w: {key: costs.effort.weight, values: [1, -1]}}\n",
                "plan.yaml:3:50: a number that is not negative is expected here, not -1"},
        BadPlan{"vary: {w: {key: costs.effort.weight, values: []}}\n",
                "plan.yaml:3:46: there is no value"},
        BadPlan{"vary: {w: {key: costs.effort.weight, linspace: [1, 2, 0]}}\n",
                "plan.yaml:3:55: a whole number from 1 to 1000000 is expected here, not 0"},
        BadPlan{"vary: {w: {key: costs.effort.weight, linspace: [1, 2, 1]}}\n",
                "plan.yaml:3:55: one value cannot reach from the first to the last"},
        BadPlan{"vary: {w: {key: costs.effort.weight}}\n",
                "plan.yaml:3:11: the values of 'w' are missing"},
        BadPlan{"vary: {w: {key: costs.effort.weight, values: [1], linspace: [1, 2, 3]}}\n",
                "plan.yaml:3:51: 'values' and 'linspace' exclude each other"},
        BadPlan{"vary: {w: {values: [1]}}\n", "plan.yaml:3:11: 'vary.w' lacks the key 'key'"},
        BadPlan{"vary: {w: {key: phases.third.dt, values: [1]}}\n",
                "plan.yaml:3:24: 'third' is neither a name nor an index in a list of 2"},
        BadPlan{"vary: {a: {key: costs.effort.weight, values: [1]}, b: {key: costs.effort, "
                "values: [1]}}\n",
                "plan.yaml:3:61: 'costs.effort' is varied twice"},
        BadPlan{"vary: {a: {key: costs.effort.weight, values: [1, 2, 1.0]}}\n",
                "plan.yaml:3:53: items 1 and 3 are the same problem with the same settings"},
        BadPlan{"vary: {a: {key: costs.effort.weight, values: [3, =1+2]}}\n",
                "plan.yaml:3:50: items 1 and 2 are the same problem with the same settings"},
        BadPlan{"vary: {p: {keys: [costs.effort.weight, phases.0.dt], values: [[1, 2], [3]]}}\n",
                "plan.yaml:3:71: this row has 1 values, and there are 2 keys"},
        BadPlan{"vary: {t: {file: goals.csv, columns: {angel: costs.effort.weight}}}\n",
                "plan.yaml:3:39: the table has no column 'angel'"},
        BadPlan{"vary: {t: {file: goals.csv, columns: {angle: costs.effort.weight}}}\n",
                "goals.csv:4:1: this line has 1 cells, the header has 2"},
        BadPlan{"vary: {s: {perturb: gravity, spread: 1, count: 2}}\n",
                "plan.yaml:3:21: unknown perturbation 'gravity'"},
        BadPlan{"vary:\n  a: {key: costs.effort.weight, linspace: [1, 2, 1000]}\n"
                "  b: {key: phases.0.dt, linspace: [0.1, 0.2, 1000]}\n"
                "  c: {key: phases.1.dt, linspace: [0.1, 0.2, 1000]}\n",
                "plan.yaml:4:3: the plan has 1000000000 items, and a batch has at most 1000000"},
        BadPlan{"solvers: [ilqr, altr0]\n", "plan.yaml:3:17: unknown solver 'altr0'"},
        BadPlan{"solvers: [ipopt, ilqr, ilqr]\n",
                "plan.yaml:3:24: 'ilqr' stands twice in the list"},
        BadPlan{"command: loop\n", "plan.yaml:3:10: unknown command 'loop'"},
        BadPlan{"command: mpc\nkeep: {solutions: all}\n",
                "plan.yaml:4:7: closed loops have no solutions that could be kept"},
        BadPlan{"command: mpc\nwarm_start: neighbour\n",
                "plan.yaml:4:13: closed loops start from the guesses of their problems"},
        BadPlan{"limits: {max_time_s: 0}\n",
                "plan.yaml:3:22: a number from 0.001 to 1e9 is expected here, not 0"},
        BadPlan{"keep: {solutions: some}\n", "plan.yaml:3:19: unknown answer 'some'"},
        BadPlan{"vary: {cost: {key: costs.effort.weight, values: [1, 2]}}\n",
                "plan.yaml:3:8: 'cost' is a column of results.csv already"},
        BadPlan{"vary: {warm_start: {key: costs.effort.weight, values: [1, 2]}}\nwarm_start: "
                "neighbour\n",
                "plan.yaml:3:8: 'warm_start' is a column of results.csv already"},
        BadPlan{"vary: {a: {key: costs.effort.weight, uniform: [2, 1], count: 3}}\n",
                "plan.yaml:3:47: the lower end lies above the upper one"},
        BadPlan{"vary: {a: {sobol: {costs.effort.weight: [2, 1]}, count: 3}}\n",
                "plan.yaml:3:41: the lower end lies above the upper one"},
        BadPlan{"vary: {a: {key: costs.effort.weight, normal: [1, -0.1], count: 3}}\n",
                "plan.yaml:3:46: the standard deviation is negative"},
        BadPlan{"vary: {a: {key: solver.max_time_s, values: [1, 2]}}\nlimits: {max_time_s: 3}\n",
                "plan.yaml:3:17: 'solver.max_time_s' is varied, and 'limits.max_time_s' sets the "
                "time of all items"},
        BadPlan{
            "vary: {a: {key: mpc.delay, values: [0, 0.1]}}\n",
            "plan.yaml:3:17: 'mpc.delay' is varied, but solves do not use keys of closed loops"},
        BadPlan{"vary: {a: {key: initial_guess.states, values: [x, y]}}\nwarm_start: goals.csv\n",
                "plan.yaml:3:17: 'initial_guess.states' is varied, and by 'warm_start' all items "
                "start from a file"},
        BadPlan{"vary: {a: {key: phases.second.dt, values: [0.1]}, b: {key: phases.1.dt, values: "
                "[0.2]}}\n",
                "plan.yaml:3:60: 'phases.1.dt' is varied twice"},
        BadPlan{"vary: {a: {keys: [phases.0.dt, phases.first.dt], values: [[0.1, 0.2]]}}\n",
                "plan.yaml:3:32: 'phases.first.dt' is varied twice"},
        BadPlan{"vary: {a: {key: phases.1, values: [{name: x, knots: 2, dt: 0.1}]}, b: {key: "
                "phases.second.dt, values: [0.2]}}\n",
                "plan.yaml:3:77: 'phases.second.dt' is varied twice"},
        BadPlan{"vary: {a: {key: phases.0.integrator.x, values: [1]}, b: {key: "
                "phases.first.integrator, values: [1]}}\n",
                "plan.yaml:3:63: 'phases.first.integrator' is varied twice"},
        BadPlan{"vary: {s: {key: solver, values: [{name: ddp}]}}\nsolvers: [ilqr]\n",
                "plan.yaml:3:17: 'solver' is varied, and 'solvers' says which solvers items have"},
        BadPlan{"vary: {a: {perturb: guess, spread: 1, count: 2}, b: {perturb: initial_state, "
                "spread: 1, count: 2}}\n",
                "plan.yaml:3:63: 'perturbation.seed' is varied twice"},
        BadPlan{"vary: {a: {perturb: [guess, guess], spread: 1, count: 2}}\n",
                "plan.yaml:3:29: 'guess' stands twice in the list"},
        BadPlan{"vary: {t: {file: goals.csv, columns: {}}}\n",
                "plan.yaml:3:38: there is no column"},
        BadPlan{"vary: {a: {normal: {costs.effort.weight: [1, -0.1]}, count: 3}}\n",
                "plan.yaml:3:42: the standard deviation is negative"},
        BadPlan{"problems: [x.yaml]\n",
                "plan.yaml:3:1: 'problem' and 'problems' exclude each other"}));

TEST(BatchPlan, EqualDistancesMayExceedTheLargestNumber) {
  const PlannedBatch batch(
      "vary: {a: {key: initial_state.values.theta, linspace: [-1.0e+308, 1.0e+308, 3]}}\n");
  ASSERT_TRUE(batch.plan) << batch.error();
  std::vector<double> values;
  for (const auto& row : batch.plan->axes[0].rows) values.push_back(std::stod(row[0].text));
  EXPECT_EQ(values, (std::vector<double>{-1e308, 0, 1e308}));
}

TEST(BatchPlan, GridsOfWholeNumbersAreWhole) {
  const PlannedBatch batch("vary: {n: {key: solver.max_iterations, linspace: [1, 50, 50]}}\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  for (int i = 0; i < 50; ++i) EXPECT_EQ(batch.manifest->items[i].values[0], std::to_string(i + 1));
}

TEST(BatchPlan, FormulaValuesKeepTheirKinds) {
  const PlannedBatch batch(R"(command: mpc
vary:
  phase: {key: phases.0, values: [{name: "5", knots: 5, dt: =0.2/2}]}
  w: {key: costs.effort.weight, values: [=1/2, 2.0]}
  mpc: {key: mpc, values: [{horizon: 0.4, tick: 0.1, duration: 0.5, terminal: {lqr: {about: [0, 0], set: false}}}]}
solvers: [ilqr]
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(
      batch.manifest->items[0].values,
      (Strings{
          R"({"name":"5","knots":5,"dt":0.1})", "0.5",
          R"({"horizon":0.4,"tick":0.1,"duration":0.5,"terminal":{"lqr":{"about":[0,0],"set":false}}})"}));
  EXPECT_EQ(batch.manifest->items[1].values[1], "2");
}

TEST(BatchPlan, ClosedLoopsAreBuiltWithTheirSettings) {
  const std::string loop = std::string(kSwing) + "mpc: {horizon: 1, tick: 0.1, duration: 1}\n";
  const PlannedBatch batch(
      "command: mpc\nlimits: {max_time_s: 5}\nvary: {d: {key: mpc.delay, values: [0, 0.1]}}\n",
      loop);
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(batch.manifest->command, BatchCommand::kMpc);
  ASSERT_EQ(batch.diagnostics.list().size(), 1u);
  EXPECT_EQ(batch.diagnostics.list()[0].message,
            "a loop without 'stop_when' never stops early (item 1 and 1 more)");
  // The worker applies the limit, not the solver.
  EXPECT_EQ(batch.manifest->items[1].settings, (std::vector<std::string>{"mpc.delay=0.1"}));
  const PlannedBatch late("command: mpc\nvary: {d: {key: mpc.delay, values: [0, 0.2]}}\n", loop);
  EXPECT_EQ(late.error().substr(0, 14), "plan.yaml:4:40") << late.error();
  const PlannedBatch none("command: mpc\n");
  EXPECT_NE(none.error().find("has no section 'mpc'"), std::string::npos) << none.error();
}

TEST(BatchPlan, AxesMayNotUseResultColumnNames) {
  const std::string loop = std::string(kSwing) + "mpc: {horizon: 1, tick: 0.1, duration: 1}\n";
  for (const char* more : {"warm_start: none\n", "warm_start: neighbour\n", "command: mpc\n"}) {
    const PlannedBatch batch(more, loop);
    ASSERT_TRUE(batch.manifest) << batch.error();
    std::istringstream header(results_csv(*batch.manifest, {}));
    std::string line, name;
    std::getline(header, line);
    std::istringstream names(line);
    while (std::getline(names, name, ','))
      EXPECT_TRUE(is_column_of_results(name, batch.manifest->command, batch.manifest->warm_start))
          << name;
  }
  EXPECT_FALSE(is_column_of_results("warm_start", BatchCommand::kSolve, WarmStart::kNone));
  EXPECT_FALSE(is_column_of_results("w", BatchCommand::kSolve, WarmStart::kNeighbour));
  // Documents use this name for an axis of initial states.
  EXPECT_FALSE(is_column_of_results("start", BatchCommand::kSolve, WarmStart::kNeighbour));
  EXPECT_FALSE(is_column_of_results("iterations", BatchCommand::kMpc, WarmStart::kNone));
}

TEST(RunFolder, AllowsReshardingButNoOtherPlanOrBuild) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n");
  const auto run = batch.folder.path() / "run";
  const auto written = [&](const Manifest& manifest) {
    Diagnostics out;
    write_run_folder(*batch.plan, manifest, run, out);
    return out.list().empty() ? std::string() : out.list().front().message;
  };
  Manifest manifest = *batch.manifest;
  EXPECT_EQ(written(manifest), "");
  std::filesystem::create_directory(run / "shards");
  manifest.shards = 7;
  EXPECT_EQ(written(manifest), "");
  Diagnostics out;
  EXPECT_EQ(load_manifest(run, true, out)->shards, 7);
  manifest.build["version"] = "0.0.0";
  EXPECT_NE(written(manifest).find("has results of this plan by another build of conddp"),
            std::string::npos)
      << written(manifest);
  manifest = *batch.manifest;
  manifest.items.pop_back();
  EXPECT_NE(written(manifest).find("has results of another plan"), std::string::npos);
  // Without results, a plan may be edited but not replaced by another.
  std::filesystem::remove(run / "shards");
  EXPECT_EQ(written(manifest), "");
  manifest.name = "other";
  EXPECT_NE(written(manifest).find("is the run of another plan, '" + batch.manifest->name + "'"),
            std::string::npos)
      << written(manifest);
}

TEST(RunFolder, KeepsAPlanOfTheUser) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n");
  std::filesystem::create_directory(batch.folder.path() / "run");
  const auto file = batch.folder.write("run/plan.yaml", "mine\n");
  Diagnostics out;
  write_run_folder(*batch.plan, *batch.manifest, batch.folder.path() / "run", out);
  ASSERT_TRUE(out.has_errors());
  EXPECT_NE(out.list().front().message.find("has a plan.yaml that is not this plan"),
            std::string::npos);
  std::ifstream stream(file);
  std::string text;
  std::getline(stream, text);
  EXPECT_EQ(text, "mine");
}

TEST(Manifest, RejectsInconsistentHeads) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n");
  const std::string head = manifest_head(*batch.manifest);
  for (const auto& [good, bad] :
       {std::pair{"\"solvers\":1", "\"solvers\":0"}, std::pair{"\"solvers\":1", "\"solvers\":3"},
        std::pair{"\"shards\":1", "\"shards\":0"}, std::pair{"\"items\":2", "\"items\":-2"},
        std::pair{"\"items\":2", "\"items\":2000000"}}) {
    std::string text = head + "\n";
    ASSERT_NE(text.find(good), std::string::npos) << good;
    text.replace(text.find(good), std::string(good).size(), bad);
    for (const ManifestItem& item : batch.manifest->items) text += manifest_line(item) + "\n";
    batch.folder.write("manifest.jsonl", text);
    Diagnostics out;
    EXPECT_FALSE(load_manifest(batch.folder.path(), true, out)) << bad;
    EXPECT_EQ(out.list().front().message, "the head of the manifest is damaged") << bad;
  }
}

TEST(Manifest, RejectsEditedLines) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n");
  const auto run = batch.folder.path() / "run";
  Diagnostics out;
  write_run_folder(*batch.plan, *batch.manifest, run, out);
  EXPECT_TRUE(load_manifest(run, true, out)) << format_diagnostics(out, false);
  std::string text = text_of(run / kManifestFile);
  const std::string weight = "costs.effort.weight=2";
  text.replace(text.find(weight), weight.size(), "costs.effort.weight=3");
  batch.folder.write("run/manifest.jsonl", text);
  EXPECT_FALSE(load_manifest(run, true, out));
  EXPECT_EQ(out.list().front().line, 3);
}

TEST(RunFolder, WarnsIfItemsHaveNoTimeLimit) {
  const auto warnings = [](const std::string& plan, const std::string& problem) {
    const PlannedBatch batch(plan, problem);
    EXPECT_TRUE(batch.manifest) << batch.error();
    Diagnostics out;
    write_run_folder(*batch.plan, *batch.manifest, batch.folder.path() / "run", out);
    warn_without_time_limit(*batch.manifest, batch.folder.path() / "run", out);
    return out.list().size();
  };
  const std::string loop = std::string(kSwing) + "mpc: {horizon: 1, tick: 0.1, duration: 1}\n";
  std::string limited = kSwing;
  limited.replace(limited.find("{name: ilqr}"), 12, "{name: ilqr, max_time_s: 5}");
  EXPECT_EQ(warnings("", kSwing), 1u);
  EXPECT_EQ(warnings("limits: {max_time_s: 5}\n", kSwing), 0u);
  EXPECT_EQ(warnings("vary: {t: {key: solver.max_time_s, values: [1, 2]}}\n", kSwing), 0u);
  EXPECT_EQ(warnings("", limited), 0u);
  EXPECT_EQ(warnings("command: mpc\n", loop), 1u);
}

TEST(Neighbours, DescendantsFollowTheirParents) {
  const PlannedBatch batch(R"(vary:
  w: {key: costs.effort.weight, linspace: [1, 2, 40]}
warm_start: neighbour
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  std::vector<std::size_t> expected = {29, 30, 31, 39};  // a block ends at 32
  EXPECT_EQ(with_descendants(*batch.manifest, {29, 39}), expected);
  EXPECT_TRUE(with_descendants(*batch.manifest, {}).empty());
}

TEST(BatchPlan, ReportsWrongCellInItsTable) {
  PlannedBatch batch("vary: {t: {file: goals.csv, columns: {angle: costs.effort.weight}}}\n");
  batch.folder.write("goals.csv", "angle,w\n1,0.5\n x,0.5\n");
  batch.plan_again();
  EXPECT_EQ(
      batch.error(),
      "goals.csv:3:2: a number that is not negative is expected here, and 'x' is not a number");
}

TEST(BatchPlan, NamesTableRowForErrorsElsewhere) {
  std::string text = kSwing;
  text.replace(text.find("weight: 0.5"), 11, "weight: =w");
  PlannedBatch batch("vary: {t: {file: goals.csv, columns: {w: parameters.w}}}\n",
                     text + "parameters: {w: 1}\n");
  batch.folder.write("goals.csv", "angle,w\n1,0.5\n2,-1\n");
  batch.plan_again();
  EXPECT_EQ(batch.error().substr(0, 11), "swing.yaml:") << batch.error();
  const Diagnostic& last = batch.diagnostics.list().back();
  EXPECT_EQ(last.severity, Severity::kNote);
  EXPECT_EQ(std::filesystem::path(last.file).filename(), "goals.csv");
  EXPECT_EQ(last.line, 3);
}

TEST(BatchPlan, CellsMayBeQuotedListsWordsAndTexts) {
  PlannedBatch batch(R"(vary:
  rows: {file: rows.csv, columns: {start: initial_state, rule: integrator, note: description}}
)");
  batch.folder.write("rows.csv",
                     "item,start,message,rule,note\n"
                     "1,\"{state: [0.1, 0.2]}\",\"a \"\"word\"\", two\",rk4,\"a: b, c\"\n"
                     "2,\"{state: [0.3, 0]}\",,rk3,plain\n");
  batch.plan_again();
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(settings(batch, 0), (Strings{"initial_state={state: [0.1, 0.2]}", "integrator=rk4",
                                         "description=\"a: b, c\""}));
  EXPECT_EQ(settings(batch, 1).back(), "description=plain");
}

TEST(BatchPlan, ReadsItsOwnResultsAsATable) {
  PlannedBatch first(
      "vary: {s: {key: initial_state, values: [{state: [0.1, 0]}, {state: [1, 2]}]}}\n");
  ASSERT_TRUE(first.manifest) << first.error();
  std::string table = results_csv(*first.manifest, {});
  EXPECT_NE(table.find("\"{\"\"state\"\":[0.1,0]}\""), std::string::npos) << table;
  PlannedBatch second("vary: {r: {file: results.csv, columns: {s: initial_state}}}\n");
  second.folder.write("results.csv", table);
  second.plan_again();
  ASSERT_TRUE(second.manifest) << second.error();
  EXPECT_EQ(second.manifest->items[1].values, first.manifest->items[1].values);
}

TEST(BatchPlan, TableErrorsHaveTheirPlaceThere) {
  struct Case {
    const char *table, *error;
  };
  const Case cases[] = {
      {"w,other,w\n1,2,3\n", "goals.csv:1:9: two columns have the name 'w'"},
      {"other,w\n1,\"[1, 2\"\n", "goals.csv:2:3: in the column 'w': this '[' is never closed"},
      {"other,w\n1,\"1, 2\n", "goals.csv:2:1: this line has 3 cells, the header has 2"}};
  for (const Case& c : cases) {
    PlannedBatch batch("vary: {t: {file: goals.csv, columns: {w: costs.effort.weight}}}\n");
    batch.folder.write("goals.csv", c.table);
    batch.plan_again();
    EXPECT_EQ(batch.error(), c.error);
  }
}

TEST(BatchPlan, ReportsMisspeltParameterInThePlan) {
  const PlannedBatch batch("vary: {g: {key: parameters.gaol, linspace: [0.5, 1.5, 3]}}\n",
                           "parameters: {goal: 1}\n" + std::string(kSwing));
  EXPECT_EQ(
      batch.error(),
      "plan.yaml:3:28: the file has no 'parameters.gaol': there is no 'gaol' in 'parameters'");
}

TEST(BatchPlan, NamesEqualProblems) {
  const std::string swing = "name: swing\n" + std::string(kSwing);
  PlannedBatch batch("", swing);
  batch.folder.write("again.yaml", swing);
  batch.file =
      batch.folder.write("plan.yaml", "conddp_batch: 1\nproblems: [swing.yaml, again.yaml]\n");
  batch.plan_again();
  EXPECT_NE(batch.error().find("items 1 and 2 are the same problem with the same settings: '"),
            std::string::npos)
      << batch.error();
  for (const char* name : {"/swing.yaml' and '", "/again.yaml'"})
    EXPECT_NE(batch.error().find(name), std::string::npos) << batch.error();
}

TEST(BatchPlan, LiteralFileNameBeatsAPattern) {
  PlannedBatch batch("");
  batch.folder.write("swing[1].yaml", kSwing);
  batch.file = batch.folder.write("plan.yaml", "conddp_batch: 1\nproblem: \"swing[1].yaml\"\n");
  batch.plan_again();
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(batch.manifest->problems.size(), 1u);
}

TEST(BatchPlan, ReportsBothUnknownAndDuplicateSolvers) {
  const PlannedBatch batch("solvers: [foo, auto, auto]\n");
  const std::string all = format_diagnostics(batch.diagnostics, false);
  EXPECT_NE(all.find("unknown solver 'foo'"), std::string::npos) << all;
  EXPECT_NE(all.find("'auto' stands twice in the list"), std::string::npos) << all;
}

/// Identity of a loop in a folder, as a batch computes it.
std::string identity_of(const std::filesystem::path& file) {
  Diagnostics out;
  const auto family = ProblemFamily::load(file, {}, out);
  EXPECT_TRUE(family) << format_diagnostics(out, false);
  return family ? batch_identity(*family, BatchCommand::kMpc) : std::string();
}

TEST(BatchPlan, LoopIdentityIncludesCommandsAndCycles) {
  const TemporaryFolder folder;
  std::string text = text_of(source_tree() / "problems/mpc/quadruped_commands.yaml");
  const std::string robots = "../robots", velocity = "{at: 4, velocity: [0, 0.15, 0]}";
  text.replace(text.find(robots), robots.size(), (source_tree() / "problems/robots").string());
  const std::string first = identity_of(folder.write("a.yaml", text));
  EXPECT_EQ(identity_of(folder.write("a.yaml", "# a comment\n" + text)), first);
  std::string changed = text;
  changed.replace(changed.find(velocity), velocity.size(), "{at: 4, velocity: [0, 0.16, 0]}");
  EXPECT_NE(identity_of(folder.write("a.yaml", changed)), first);
  const std::string repeat = "repeat: gait";
  changed = text;
  changed.replace(changed.find(repeat), repeat.size(), "repeat: hold");
  EXPECT_NE(identity_of(folder.write("a.yaml", changed)), first);
}

TEST(BatchPlan, LoopIdentityIncludesPlantFiles) {
  const TemporaryFolder folder;
  const std::string robot = text_of(source_tree() / "problems/robots/cartpole.urdf");
  folder.write("model.urdf", robot);
  folder.write("plant.urdf", robot);
  const auto file = folder.write("a.yaml", R"(conddp: 1
robot: {urdf: model.urdf, actuation: {joints: [slider]}}
initial_state: {}
phases: [{name: only, knots: 5, dt: 0.1}]
costs: {effort: {residual: control}}
mpc: {horizon: 0.5, tick: 0.1, duration: 0.5, plant: {set: {robot.urdf: plant.urdf}}}
)");
  const std::string first = identity_of(file);
  folder.write("plant.urdf", robot + "<!-- heavier -->\n");
  EXPECT_NE(identity_of(file), first);
}

TEST(BatchPlan, NamesTheItemThatCannotBeBuilt) {
  const PlannedBatch batch(R"(vary:
  a: {key: phases.0.dt, values: [0.1, 0.2]}
  b: {key: costs.effort.weight, values: [1, -1]}
)");
  EXPECT_EQ(batch.error(),
            "plan.yaml:5:45: a number that is not negative is expected here, not -1");
  const Diagnostic& note = batch.diagnostics.list().back();
  EXPECT_EQ(note.severity, Severity::kNote);
  EXPECT_NE(note.message.find("item 2 of 4"), std::string::npos) << note.message;
  EXPECT_NE(note.message.find("phases.0.dt=0.1, costs.effort.weight=-1"), std::string::npos)
      << note.message;
}

TEST(BatchPlan, ExplainsHowAPlanChoosesASolver) {
  const PlannedBatch batch(
      "solvers: [ilqr]\n",
      std::string(kSwing) + "constraints: {torque: {bounds: control, lower: -1, upper: 1}}\n");
  EXPECT_NE(batch.error().find("ilqr does not support the control bounds"), std::string::npos);
  const Diagnostic& error = batch.diagnostics.list().front();
  EXPECT_EQ(error.hint, "choose one of them under 'solvers'; 'auto' does so by the problem");
}

TEST(BatchPlan, AnEmptyTableHasNoColumns) {
  PlannedBatch batch("vary: {t: {file: goals.csv, columns: {angle: costs.effort.weight}}}\n");
  batch.folder.write("goals.csv", "");
  batch.plan_again();
  EXPECT_EQ(batch.error(),
            "goals.csv:1:1: the table is empty: the names of its columns are expected in its first "
            "line");
  EXPECT_EQ(batch.diagnostics.list().front().hint, "");
}

TEST(BatchPlan, RobotSettingsReloadTheRobot) {
  PlannedBatch batch("");
  batch.folder.write("arm.yaml", "conddp: 1\nrobot: {urdf: " + source_tree().string() +
                                     "/problems/robots/arm7.urdf}\ninitial_state: {}\n"
                                     "phases: [{name: only, knots: 3, dt: 0.1}]\n"
                                     "costs: {effort: {residual: control}}\n");
  Diagnostics out;
  const auto family = ProblemFamily::load(batch.folder.path() / "arm.yaml", {}, out);
  ASSERT_TRUE(family) << format_diagnostics(out, false);
  const auto mass = [&](const std::string& text) {
    Diagnostics own = family->texts();
    const auto instance = family->build({*parse_setting(text, own)}, own);
    EXPECT_TRUE(instance) << format_diagnostics(own, false);
    return instance->plant.robot().total_mass();
  };
  const double plain = mass("costs.effort.weight=2");
  EXPECT_NEAR(mass("robot.payloads={link_7: {mass: 10}}") - plain, 10, 1e-12);
  const auto system_of = [&](const std::string& text) {
    Diagnostics own = family->texts();
    return family->build({*parse_setting(text, own)}, own)->plant.system;
  };
  EXPECT_EQ(system_of("costs.effort.weight=2"), system_of("phases.only.knots=5"));
}

/// One-based parent of each item; 0 for items without a parent.
std::vector<int> parents(const Manifest& manifest) {
  std::vector<int> list;
  for (const ManifestItem& item : manifest.items) {
    int parent = 0;
    for (std::size_t i = 0; i < manifest.items.size(); ++i)
      if (manifest.items[i].id == item.parent) parent = static_cast<int>(i) + 1;
    list.push_back(parent);
  }
  return list;
}

TEST(Neighbours, ParentsAreNearestEarlierItemsByScaledDistance) {
  const PlannedBatch batch(R"(vary:
  w: {key: costs.effort.weight, values: [1, 2, 5, 3.4]}
  theta: {key: initial_state.values.theta, values: [0.1, 0.5, 0.22]}
warm_start: neighbour
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  // In units of the ranges 4 and 0.4: (0, 0), (0, 1), (0, 0.3), (0.25, 0), ...
  EXPECT_EQ(parents(*batch.manifest), (std::vector<int>{0, 1, 1, 1, 2, 3, 4, 5, 7, 4, 5, 10}));
}

TEST(Neighbours, BlocksHaveOneSolverAndAtMost32Rows) {
  const PlannedBatch batch(R"(vary:
  w: {key: costs.effort.weight, linspace: [1, 2, 70]}
solvers: [ilqr, ddp]
warm_start: neighbour
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  const Manifest& manifest = *batch.manifest;
  const std::vector<int> parent = parents(manifest);
  for (int i = 0; i < 140; ++i) {
    const int row = i / 2;
    EXPECT_EQ(parent[i], row % 32 == 0 ? 0 : i - 2 + 1) << i;
    EXPECT_EQ(block_of(manifest, i), 2u * (row / 32) + i % 2) << i;
  }
  std::vector<int> seen(140);
  for (int shard = 0; shard < 4; ++shard) {
    std::size_t before = 0;
    for (const std::size_t item : items_of_shard(manifest, {shard, 4})) {
      ++seen[item];
      EXPECT_EQ(block_of(manifest, item) % 4, static_cast<std::size_t>(shard));
      EXPECT_GE(block_of(manifest, item), before);
      before = block_of(manifest, item);
    }
  }
  EXPECT_EQ(seen, std::vector<int>(140, 1));
}

TEST(Neighbours, NonNumericValuesAreEqualOrOneApart) {
  const PlannedBatch batch(R"(vary:
  name: {key: integrator, values: [rk4, rk3]}
  w: {key: costs.effort.weight, values: [1, 1.4, 2]}
warm_start: neighbour
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(parents(*batch.manifest), (std::vector<int>{0, 1, 2, 1, 4, 5}));
}

TEST(Neighbours, NumbersInListsAndMappingsHaveTheirDistances) {
  const PlannedBatch batch(R"(vary:
  weights: {key: costs.effort.weights, values: [[1], [9], [2], [8], [1.1]]}
  initial: {key: initial_state.values, values: [{theta: 0.1}, {theta: 1, omega: 1}, {theta: 0.2}]}
warm_start: neighbour
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(parents(*batch.manifest),
            (std::vector<int>{0, 1, 1, 1, 2, 4, 1, 2, 7, 4, 5, 10, 1, 2, 3}));
}

TEST(Neighbours, WithoutWarmStartsEveryItemIsABlock) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [1, 2, 3]}}\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(parents(*batch.manifest), (std::vector<int>{0, 0, 0}));
  EXPECT_EQ(items_of_shard(*batch.manifest, {1, 2}), std::vector<std::size_t>{1});
}

TEST(Neighbours, ParentsHaveTheSameShape) {
  const PlannedBatch batch(R"(vary:
  knots: {key: phases.first.knots, values: [4, 5]}
  w: {key: costs.effort.weight, values: [1, 2, 3]}
warm_start: neighbour
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(parents(*batch.manifest), (std::vector<int>{0, 1, 2, 0, 4, 5}));
}

TEST(BatchPlan, ReportsKeysThatDifferInOneProblem) {
  PlannedBatch batch("");
  std::string other = kSwing;
  other.replace(other.find("{name: second"), 13, "{name: third");
  batch.folder.write("other.yaml", other);
  batch.file = batch.folder.write("plan.yaml", R"(conddp_batch: 1
problems: [swing.yaml, other.yaml]
vary: {a: {key: phases.1.dt, values: [0.1]}, b: {key: phases.third.dt, values: [0.2]}}
)");
  batch.plan_again();
  EXPECT_EQ(batch.error(), "plan.yaml:3:55: 'phases.third.dt' is varied twice");
}

const std::string kMoving =
    std::string(kSwing).replace(std::string(kSwing).find("{name: ilqr}"), 12,
                                "{name: ilqr, homotopy: [{key: costs.effort.weight, from: 5, "
                                "to: 0.5}]}");

TEST(BatchPlan, VariesHomotopyNumbersAtTheirEnd) {
  const PlannedBatch batch("vary: {w: {key: costs.effort.weight, values: [0.5, 0.7]}}\n", kMoving);
  EXPECT_EQ(batch.error().find("plan.yaml:3:17: 'costs.effort.weight' is varied, and the homotopy"),
            0u)
      << batch.error();
  EXPECT_EQ(batch.diagnostics.list().back().hint, "vary 'solver.homotopy.0.to' instead");
  const PlannedBatch ends("vary: {w: {key: solver.homotopy.0.to, values: [0.5, 0.7]}}\n", kMoving),
      none(
          "vary: {w: {key: costs.effort.weight, values: [0.5, 0.7]}, h: {key: solver.homotopy, "
          "values: [[]]}}\n",
          kMoving);
  EXPECT_TRUE(ends.manifest) << ends.error();
  EXPECT_TRUE(none.manifest) << none.error();
}

TEST(BatchPlan, ReportsItemWarningsOnceWithFirstItem) {
  const PlannedBatch batch("vary: {w: {key: solver.homotopy.0.to, values: [0.5, 0.7, 0.8]}}\n",
                           kMoving);
  ASSERT_TRUE(batch.manifest) << batch.error();
  std::vector<std::string> warnings;
  for (const Diagnostic& d : batch.diagnostics.list())
    if (d.severity == Severity::kWarning) warnings.push_back(d.message);
  EXPECT_EQ(warnings,
            Strings{"0.5 has no effect: a homotopy moves this number to 0.7 (item 2 and 1 more)"});
}

TEST(BatchPlan, ProblemWarningsAreNotRepeated) {
  std::string moving = kMoving;
  moving.replace(moving.find("to: 0.5"), 7, "to: 0.6");
  const PlannedBatch batch("vary: {t: {key: initial_state.values.theta, values: [0.1, 0.2]}}\n",
                           moving);
  ASSERT_TRUE(batch.manifest) << batch.error();
  const auto& list = batch.diagnostics.list();
  EXPECT_EQ(std::count_if(list.begin(), list.end(),
                          [](const Diagnostic& d) { return d.severity == Severity::kWarning; }),
            1)
      << format_diagnostics(batch.diagnostics, false);
}

TEST(BatchPlan, DrawsSeveralKeysTogether) {
  const PlannedBatch batch(R"(vary:
  n: {normal: {costs.effort.weight: [5, 0.1], initial_state.values.theta: [0, 1]}, count: 3}
  u: {uniform: {phases.0.dt: [0.1, 0.2], phases.1.dt: [0.01, 0.02]}, count: 2, seed: 4}
)");
  ASSERT_TRUE(batch.manifest) << batch.error();
  ASSERT_EQ(batch.manifest->items.size(), 6u);
  EXPECT_EQ(batch.manifest->columns[1].name, "initial_state.values.theta");
  std::set<double> steps;  // from the mean, in standard deviations
  for (const ManifestItem& item : batch.manifest->items) {
    steps.insert((std::stod(item.values[0]) - 5) / 0.1);
    steps.insert(std::stod(item.values[1]));
    const double dt = std::stod(item.values[3]);
    EXPECT_TRUE(dt >= 0.01 && dt < 0.02) << dt;
  }
  EXPECT_EQ(steps.size(), 6u);  // each key has its own draws
  EXPECT_GT(std::abs(*std::next(steps.begin()) - *steps.begin()), 1e-6);
}

TEST(BatchPlan, PerturbsInitialStateAndGuessTogether) {
  const PlannedBatch batch(
      "vary: {s: {perturb: [initial_state, guess], spread: 0.1, count: 2, seed: 7}}\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  EXPECT_EQ(settings(batch, 1), (Strings{"perturbation.initial_state=0.1", "perturbation.guess=0.1",
                                         "perturbation.seed=8"}));
  Strings names;
  for (const ManifestColumn& column : batch.manifest->columns) names.push_back(column.name);
  EXPECT_EQ(names, (Strings{"s.initial_state", "s.guess", "s"}));
}

TEST(BatchPlan, TellsProblemFilesFromPlans) {
  PlannedBatch batch("");
  Diagnostics out;
  EXPECT_FALSE(load_batch_plan(batch.folder.path() / "swing.yaml", out));
  ASSERT_EQ(out.list().size(), 1u) << format_diagnostics(out, false);
  EXPECT_EQ(out.list()[0].message, "this is a problem file, not a plan of a batch");
  batch.file = batch.folder.write("of_plans.yaml", "conddp_batch: 1\nproblem: plan.yaml\n");
  batch.plan_again();
  EXPECT_EQ(batch.error(), "plan.yaml:1:1: this is a plan of a batch, not a problem file");
  EXPECT_EQ(batch.diagnostics.error_count(), 1);
}

TEST(BatchPlan, DuplicateKeyIsOneError) {
  const PlannedBatch batch("vary: {a: {keys: [phases.0.dt, phases.0.dt], values: [[1, 2]]}}\n");
  EXPECT_EQ(batch.error(), "plan.yaml:3:32: 'phases.0.dt' stands twice in the list");
  EXPECT_EQ(batch.diagnostics.error_count(), 1);
}

TEST(BatchPlan, ExplainsAPatternInAFolder) {
  PlannedBatch batch("");
  batch.file = batch.folder.write("plan.yaml", "conddp_batch: 1\nproblem: \"d?/x.yaml\"\n");
  batch.plan_again();
  EXPECT_EQ(batch.diagnostics.list().front().hint,
            "'*', '?' and '[...]' match files only in the last part of a path");
}

TEST(BatchPlan, UnansweredItemsHaveTheSolverOfThePlan) {
  const PlannedBatch batch("solvers: [ilqr, ddp]\n");
  ASSERT_TRUE(batch.manifest) << batch.error();
  StoredResults results;
  const ManifestItem& crashed = batch.manifest->items[0];
  results[crashed.id] = {.result = {.id = crashed.id,
                                    .status = "crashed",
                                    .answer = {{"message", "signal 6"}},
                                    .times = OrderedJson::object()}};
  const std::string table = results_csv(*batch.manifest, results);
  EXPECT_NE(table.find(",ilqr,crashed,0,"), std::string::npos) << table;
  EXPECT_NE(table.find(",ddp,unfinished,"), std::string::npos) << table;
}

TEST(BatchPlan, AllItemsMayStartFromAFile) {
  PlannedBatch missing("warm_start: nowhere.json\n");
  EXPECT_FALSE(missing.manifest);
  EXPECT_NE(missing.error().find("'nowhere.json' is neither a warm start nor an existing file"),
            std::string::npos)
      << missing.error();
  PlannedBatch wrong("warm_start: former.json\n");
  wrong.folder.write("former.json", "{\"format\": \"conddp.bench/1\"}");
  wrong.plan_again();
  EXPECT_FALSE(wrong.manifest);
}

TEST(BatchPlan, ReportsWarmStartErrorsInTheirFile) {
  PlannedBatch batch("warm_start: former.csv\n");
  batch.folder.write("former.csv", "t,other\n0,1\n1,2\n");
  batch.plan_again();
  ASSERT_FALSE(batch.diagnostics.list().empty());
  EXPECT_EQ(batch.error().find("plan.yaml:3:13: "), 0u) << batch.error();
}

constexpr const char* kGuess = "t,theta,omega,torque\n0,0.1,0,0\n0.7,1,0,0\n";

// A worker holds one problem at a time.
TEST(BatchPlan, ItemIdsIgnoreDataOfOtherProblems) {
  PlannedBatch batch("");
  batch.folder.write("a.csv", kGuess);
  batch.folder.write("guided.yaml", std::string(kSwing) + "initial_guess: {file: a.csv}\n");
  batch.file = batch.folder.write("plan.yaml", R"(conddp_batch: 1
problems: [guided.yaml, swing.yaml]
vary: {g: {key: initial_guess, values: [{states: interpolate}, {file: a.csv}]}}
)");
  batch.plan_again();
  ASSERT_TRUE(batch.manifest) << batch.error();
  for (const ManifestItem& item : batch.manifest->items) {
    Diagnostics out;
    const auto family = ProblemFamily::load(batch.plan->problems[item.problem].value, {}, out);
    Diagnostics texts = family->texts();
    const std::vector<Setting> list{*parse_setting(item.settings.at(0), texts)};
    const auto instance = family->build(list, texts);
    ASSERT_TRUE(instance) << format_diagnostics(texts, false);
    EXPECT_EQ(item_id(*batch.manifest, item.problem, list, input_files(*instance)), item.id);
  }
}

TEST(RunFolder, RejectsChangesOfInputFiles) {
  PlannedBatch batch("vary: {g: {key: initial_guess, values: [{file: a.csv}, {file: b.csv}]}}\n");
  const std::string table = kGuess;
  batch.folder.write("a.csv", table);
  batch.folder.write("b.csv", table + "\n");
  batch.plan_again();
  ASSERT_TRUE(batch.manifest) << batch.error();
  const std::filesystem::path run = batch.folder.path() / "run";
  write_run_folder(*batch.plan, *batch.manifest, run, batch.diagnostics);
  Diagnostics same;
  auto manifest = load_manifest(run, true, same);
  ASSERT_TRUE(manifest && fits_run_folder(*manifest, run, false, same))
      << format_diagnostics(same, false);
  batch.folder.write("b.csv", table + "\n\n");
  Diagnostics changed;
  EXPECT_FALSE(fits_run_folder(*manifest, run, false, changed));
  EXPECT_NE(changed.list()[0].message.find("b.csv', which items read, has changed"),
            std::string::npos)
      << changed.list()[0].message;
}

}  // namespace
}  // namespace conddp
