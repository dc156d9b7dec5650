// Output of conddp batch: data sets, files of single items, reports.
#include <cstdlib>

#include "batch_fixture.hpp"

namespace conddp {
namespace {

TEST_F(Batch, DataSetIsReproducibleHoweverTheRunWent) {
  const std::string one = planned("one"), other = planned("other_way");
  EXPECT_EQ(run(one, {"-j", "1"}).exit_code, 0);
  for (const char* shard : {"3/3", "1/3", "2/3"})
    EXPECT_EQ(run(other, {"--shard", shard}).exit_code, 0);
  collected(one);
  collected(other);
  const std::string data = read_file(one + "/dataset.h5");
  EXPECT_GT(data.size(), 10'000u);
  EXPECT_TRUE(data == read_file(other + "/dataset.h5"));

  const std::string id = ids(one)[17], item = folder_.path() / "item";
  EXPECT_EQ(run_conddp({"batch", "show", one, id, "-o", item}).exit_code, 0);
  const std::string script = folder_.write("read.py", R"(
import json, sys, h5py
solution = json.load(open(sys.argv[2]))
shape = h5py.File(sys.argv[1])["shape_1"]
assert shape["item"].shape == (30,), shape["item"]
i = list(shape["id"]).index(sys.argv[3].encode())
assert shape["item"][i] == 18
assert shape["status"][i] == b"converged"
assert shape["cost"][i] == solution["cost"]
for name in ("t", "x", "u"):
    assert shape[name][i].tolist() == solution["trajectory"][name], name
for name in ("k", "K"):
    assert shape[name][i].tolist() == solution["gains"][name], name
assert shape["costates"][i].tolist() == solution["multipliers"]["costates"]
assert list(shape["x"].attrs["columns"]) == [b"theta", b"omega"], list(shape["x"].attrs["columns"])
assert list(shape["parameters"].attrs["names"]) == [b"w", b"start.spread", b"start"]
w, spread, seed = shape["parameters"][i].tolist()
assert abs(w - 1.28) < 1e-12 and spread == 0.2 and seed == 3, (w, spread, seed)
)");
  const std::string command = "/usr/bin/python3 " + script + " " + one + "/dataset.h5 " + item +
                              "/solution.json " + id + " > " + item + "/log 2>&1";
  EXPECT_EQ(std::system(command.c_str()), 0) << read_file(item + "/log");
}

std::string without_last_column(const std::string& table) {
  std::istringstream lines(table);
  std::string text, line;
  while (std::getline(lines, line)) text += line.substr(0, line.rfind(',')) + '\n';
  return text;
}

TEST_F(Batch, ShowWritesVerifiableProblemAndSolution) {
  const std::string folder = planned("show");
  EXPECT_EQ(run(folder).exit_code, 0);
  const std::string id = ids(folder)[17], out = folder_.path() / "item";
  const ProcessResult r = run_conddp({"batch", "show", folder, id, "-o", out});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(run_conddp({"verify", out + "/solution.json"}).exit_code, 0);
  EXPECT_EQ(run_conddp({"solve", out + "/problem.yaml", "-o", out + "/again"}).exit_code, 0);
  EXPECT_EQ(read_file(out + "/trajectory.csv"), read_file(out + "/again/trajectory.csv"));
  EXPECT_EQ(without_last_column(read_file(out + "/iterations.csv")),  // the time
            without_last_column(read_file(out + "/again/iterations.csv")));
  const auto kept = nlohmann::json::parse(read_file(out + "/solution.json")),
             again = nlohmann::json::parse(read_file(out + "/again/solution.json"));
  EXPECT_EQ(kept["trajectory"]["x"], again["trajectory"]["x"]);
  EXPECT_EQ(kept["cost"], again["cost"]);
  const ProcessResult wrong = run_conddp({"batch", "show", folder, "0123456789abcdef"});
  EXPECT_EQ(wrong.exit_code, 2);
  EXPECT_NE(wrong.err.find("has no item '0123456789abcdef'"), std::string::npos) << wrong.err;
}

TEST_F(Batch, ShowTakesTheFirstDigitsOfAnId) {
  const std::string folder = planned("show");
  const Words all = ids(folder);
  const auto shared = [&](const std::string& begin) {
    return std::count_if(all.begin(), all.end(),
                         [&](const std::string& id) { return id.starts_with(begin); });
  };
  std::string begin = all[17].substr(0, 1);
  while (shared(begin) > 1) begin = all[17].substr(0, begin.size() + 1);
  const ProcessResult r = run_conddp({"batch", "show", folder, begin});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out.find(all[17] + ": unfinished\n"), 0u) << r.out;
  // Among 30 items, at least two share the first digit.
  for (const std::string& id : all)
    if (shared(id.substr(0, 1)) > 1) {
      const ProcessResult several = run_conddp({"batch", "show", folder, id.substr(0, 1)});
      EXPECT_EQ(several.exit_code, 2);
      EXPECT_NE(several.err.find("items begin with '" + id.substr(0, 1) + "'"), std::string::npos)
          << several.err;
      return;
    }
  FAIL() << "all ids differ in their first digit";
}

TEST_F(Batch, CollectExplainsAMissingDataSet) {
  const std::string rest = "vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n";
  const std::string none = planned("none", rest + "keep: {solutions: none}\n");
  EXPECT_EQ(run(none).exit_code, 0);
  EXPECT_NE(
      run_conddp({"batch", "collect", none}).out.find("no dataset.h5: the plan keeps no solutions"),
      std::string::npos);
  const std::string unfinished = planned("unfinished", rest);
  EXPECT_NE(run_conddp({"batch", "collect", unfinished})
                .out.find("no dataset.h5: no item has a solution that is kept"),
            std::string::npos);
  EXPECT_EQ(run(unfinished).exit_code, 0);
  EXPECT_EQ(run_conddp({"batch", "collect", unfinished}).out.find("no dataset.h5"),
            std::string::npos);
}

TEST_F(Batch, SmallDataSetIsASmallFile) {
  const std::string folder =
      planned("small", "vary: {w: {key: costs.effort.weight, values: [1, 2]}}\n");
  EXPECT_EQ(run(folder).exit_code, 0);
  collected(folder);
  EXPECT_LT(std::filesystem::file_size(folder + "/dataset.h5"), 100'000u);
}

/// Runs a Python script and stores its output in `log`. Returns false on failure.
bool python(const std::string& script, const std::vector<std::string>& arguments,
            const std::string& log) {
  std::string command = "/usr/bin/python3 " + script;
  for (const std::string& argument : arguments) command += " '" + argument + "'";
  return std::system((command + " > " + log + " 2>&1").c_str()) == 0;
}
const bool kHasHdf5 = std::system("/usr/bin/python3 -c 'import h5py' 2> /dev/null") == 0;

constexpr const char* kPointRobot = R"(<robot name="point">
  <link name="base"><inertial><origin xyz="0 0 0"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="body"><inertial><origin xyz="0 0 0"/><mass value="1"/>
    <inertia ixx="0.1" iyy="0.1" izz="0.1" ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="turn" type="continuous"><parent link="base"/><child link="body"/>
    <axis xyz="0 1 0"/></joint>
</robot>
)";

TEST_F(Batch, DataSetNamesSolversFilesMultipliersAndTangents) {
  if (!kHasHdf5) GTEST_SKIP() << "h5py is not there";
  folder_.write("point.urdf", kPointRobot);
  folder_.write("swing.yaml", R"(conddp: 1
robot: {urdf: point.urdf, base: floating, actuation: {joints: [turn]}}
gravity: [0, 0, 0]
initial_state: {}
phases: [{name: only, knots: 10, dt: 0.05}]
costs: {effort: {residual: control}, rest: {residual: state, weight: 0.1}}
constraints: {gate: {residual: state, columns: v/turn, lower: -1, upper: 1, knots: [3, 5]}}
solver: {name: altro}
)");
  const std::string run = folder_.path() / "lists";
  const ProcessResult r =
      run_conddp({"batch", "run",
                  plan("vary:\n  start: {key: initial_state.base.position, values: [[0, 0, 1], "
                       "[0.1, 0, 2]]}\n  word: {key: integrator, values: [semi_implicit_euler]}\n"
                       "  rest: {key: costs.rest, values: [{residual: state, weight: 0.1}]}\n"),
                  "-o", run});
  EXPECT_EQ(r.exit_code, 0) << r.err << r.out;
  const std::string script = folder_.write("lists.py", R"(
import sys, h5py, numpy
shape = h5py.File(sys.argv[1])["shape_1"]
names = lambda array, key: [text.decode() for text in shape[array].attrs[key]]
assert names("parameters", "names") == ["start.0", "start.1", "start.2", "word", "rest.weight"]
assert names("parameters", "keys")[1] == "initial_state.base.position.1"
assert shape["parameters"][1, :3].tolist() == [0.1, 0, 2], shape["parameters"][:]
assert numpy.isnan(shape["parameters"][:, 3]).all()
assert shape["parameters"][:, 4].tolist() == [0.1, 0.1], shape["parameters"][:]
assert names("parameters", "keys")[4] == "costs.rest.weight"
assert list(shape["solver"]) == [b"altro"] * 2, list(shape["solver"])
assert list(shape["problem"]) == [b"../swing.yaml"] * 2, list(shape["problem"])
tangents = ["base/x", "base/y", "base/z", "base/rx", "base/ry", "base/rz", "q/turn"]
assert names("costates", "columns")[:7] == tangents, names("costates", "columns")
assert names("K", "tangents") == names("costates", "columns")
assert len(names("K", "tangents")) == shape["K"].shape[3] == 14
gate = shape["multiplier_gate"][:]
assert gate.shape == (2, 11, 1), gate.shape
assert numpy.isfinite(gate[:, [3, 5]]).all() and numpy.isnan(gate[:, [0, 1, 2, 4, 6, 10]]).all()
)");
  const std::string log = folder_.path() / "log";
  EXPECT_TRUE(python(script, {run + "/dataset.h5"}, log)) << read_file(log);
}

TEST_F(Batch, DataSetNamesThousandsOfParameters) {
  if (!kHasHdf5) GTEST_SKIP() << "h5py is not there";
  constexpr int kPoints = 3000;
  std::string points = "[0", values = "[0.5";
  for (int i = 1; i < kPoints; ++i) {
    points += "," + std::to_string(i);
    values += ",0.5";
  }
  const std::string run = folder_.path() / "long";
  folder_.write("swing.yaml",
                kBatchSwing + std::string("tables: {w: {points: [0, 1], values: [1, 1]}}\n"));
  const std::string rest = "vary: {table: {key: tables.w, values: [{points: " + points +
                           "], values: " + values + "]}]}}\n";
  const ProcessResult r = run_conddp({"batch", "run", plan(rest), "-o", run});
  EXPECT_EQ(r.exit_code, 0) << r.err << r.out;
  const std::string script = folder_.write("long.py", R"(
import sys, h5py
parameters = h5py.File(sys.argv[1])["shape_1"]["parameters"]
names = list(parameters.attrs["names"])
assert len(names) == 6000 and names[3001] == b"table.values.1", names[3001]
assert parameters[0, 2999] == 2999 and parameters[0, 3001] == 0.5
)");
  const std::string log = folder_.path() / "log";
  EXPECT_TRUE(python(script, {run + "/dataset.h5"}, log)) << read_file(log);
}

TEST_F(Batch, DataSetControlsExcludeInitialChoices) {
  if (!kHasHdf5) GTEST_SKIP() << "h5py is not there";
  folder_.write("swing.yaml", R"(conddp: 1
system: {type: pendulum}
initial_state: {}
phases:
  - {name: start, choose: all, lower: -1, upper: 1}
  - {name: go, knots: 10, duration: 1, free_duration: {lower: 0.5, upper: 2}}
costs:
  effort: {residual: control}
  rest: {residual: state, reference: {values: {theta: 0.5}}}
constraints: {torque: {bounds: control, lower: -2, upper: 2}}
solver: {name: altro}
)");
  const std::string run = folder_.path() / "chosen";
  const ProcessResult r = run_conddp({"batch", "run", plan(""), "-o", run});
  EXPECT_EQ(r.exit_code, 0) << r.err << r.out;
  const std::string script = folder_.write("chosen.py", R"(
import sys, h5py, numpy
shape = h5py.File(sys.argv[1])["shape_1"]
for name in ("u", "k", "K", "control_lower", "control_upper"):
    array = shape[name][0]
    assert len(array) == 11, (name, array.shape)
    assert numpy.isnan(array[0]).all() and numpy.isfinite(array[1:]).all(), (name, array)
assert shape["t"][0, 1] == 0 and shape["x"][0, 1, 0] > 0.01, shape["x"][0]
)");
  const std::string log = folder_.path() / "log";
  EXPECT_TRUE(python(script, {run + "/dataset.h5"}, log)) << read_file(log);
}

// The repository's plan, thinned to eight steps.
TEST_F(Batch, QuadrupedStepsFormAVerifiableDataSet) {
  if (!kHasHdf5) GTEST_SKIP() << "h5py is not there";
  std::string text = read_file(source("problems/batches/quadruped_steps.yaml"));
  for (const char* count : {", 20]", ", 10]", ", 10]"})
    text.replace(text.find(count), std::string(count).size(), ", 2]");
  const std::string relative = "../quadruped_trot.yaml";
  text.replace(text.find(relative), relative.size(), source("problems/quadruped_trot.yaml"));
  const std::string run = folder_.path() / "steps";
  const ProcessResult r =
      run_conddp({"batch", "run", folder_.write("steps.yaml", text), "-o", run, "-j", "2"});
  EXPECT_EQ(r.exit_code, 0) << r.err << r.out;
  const std::string script = folder_.write("steps.py", R"(
import sys, h5py, numpy
shape = h5py.File(sys.argv[1])["shape_1"]
assert shape["x"].shape[0] == 8 and set(shape["status"]) == {b"converged"}, shape["x"].shape
assert list(shape["parameters"].attrs["names"]) == [b"length", b"height", b"turn"]
columns = list(shape["x"].attrs["columns"])
yaw = 2 * shape["x"][:, -1, columns.index(b"base/qz")]  # of small turns about z
for (length, height, turn), angle in zip(shape["parameters"], yaw):
    assert angle * turn > 0, (turn, angle)
for foot in ("LF", "RF", "LH", "RH"):
    force = shape["force_" + foot][:]
    assert force.shape == (8, shape["u"].shape[1], 3), force.shape
    attributes = shape["force_" + foot].attrs
    assert list(attributes["columns"]) == [b"fx", b"fy", b"fz"]
    assert list(attributes["units"]) == [b"N"] * 3
    assert list(attributes["units_at_impulses"]) == [b"Ns"] * 3
    assert numpy.isnan(force).any() and numpy.nanmax(force[:, :, 2]) > 50  # steps, and stands
)");
  const std::string log = folder_.path() / "log";
  EXPECT_TRUE(python(script, {run + "/dataset.h5"}, log)) << read_file(log);
  for (const int item : {0, 5}) {
    const std::string out = folder_.path() / ("step" + std::to_string(item));
    EXPECT_EQ(run_conddp({"batch", "show", run, ids(run)[item], "-o", out}).exit_code, 0);
    EXPECT_EQ(run_conddp({"verify", out + "/solution.json"}).exit_code, 0);
  }
}

TEST_F(Batch, DataSetReportsAFullDisk) {
  const std::string folder = planned("full");
  EXPECT_EQ(run(folder).exit_code, 0);
  const ProcessResult r = run_conddp({"batch", "collect", folder}, {.limit_file_size = 16384});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.err,
            "conddp: error: '" + folder + "/dataset.h5' cannot be written: File too large\n");
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    EXPECT_FALSE(entry.path().filename().string().starts_with("dataset")) << entry;
}

TEST_F(Batch, WritesTablesAndReportsMissingHdf5) {
  const std::string folder = planned("without");
  EXPECT_EQ(run(folder).exit_code, 0);
  folder_.write("libraries/" CONDDP_HDF5_LIBRARY, "no library");
  const ProcessResult r =
      run_conddp({"batch", "collect", folder},
                 {.environment = {"LD_LIBRARY_PATH=" + (folder_.path() / "libraries").string()}});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.err.find("conddp: error: HDF5, which writes dataset.h5, cannot be loaded: "), 0u)
      << r.err;
  EXPECT_FALSE(read_file(folder + "/results.csv").empty());
  EXPECT_FALSE(std::filesystem::exists(folder + "/dataset.h5"));
}

TEST_F(Batch, PlanWithEveryKeyWorks) {
  folder_.write("targets.csv", "g,unused\n0.9,1\n1.1,2\n");
  const std::string every = R"(vary:
  x: {key: terminal.costs.goal.reference.values.omega, linspace: [-0.1, 0.1, 2]}
  y: {key: phases.only.dt, values: [0.05, 0.06]}
  pairs: {keys: [costs.effort.weight, terminal.costs.goal.weight], values: [[0.5, 10], [1, 20]]}
  table: {file: targets.csv, columns: {g: terminal.costs.goal.reference.values.theta}}
  draw: {perturb: initial_state, spread: 0.1, count: 2, seed: 7}
solvers: [box_ddp, proxddp]
warm_start: neighbour
limits: {max_time_s: 20, max_memory_mb: 2000, retries: 1}
keep: {solutions: )";
  for (const auto& [kept, solutions] : {std::pair{"none", 0}, std::pair{"converged", 64}}) {
    const std::string folder = planned(std::string("every_") + kept, every + kept + "}\n");
    EXPECT_EQ(run(folder, {"-j", "2"}).exit_code, 0);
    const std::string results = collected(folder);
    EXPECT_EQ(std::count(results.begin(), results.end(), '\n'), 65);
    EXPECT_EQ(results.substr(0, results.find(",solver")),
              "item,id,problem,x,y,costs.effort.weight,terminal.costs.goal.weight,g,draw.spread,"
              "draw");
    EXPECT_EQ(std::filesystem::exists(folder + "/dataset.h5"), solutions > 0);
    EXPECT_EQ(std::filesystem::file_size(folder + "/shards/1of1.solutions") > 0, solutions > 0);
  }
}

TEST_F(Batch, DoesNotMixChangedProblemsWithOldSolutions) {
  const std::string folder = planned("changed");
  EXPECT_EQ(run(folder).exit_code, 0);
  std::string changed = kBatchSwing;
  changed.replace(changed.find("weight: 10"), 10, "weight: 11");
  folder_.write("swing.yaml", changed);
  const ProcessResult show = run_conddp({"batch", "show", folder, ids(folder)[3]});
  EXPECT_EQ(show.exit_code, 2);
  EXPECT_NE(show.err.find("has changed since the plan was made"), std::string::npos) << show.err;
  const ProcessResult report = run_conddp({"batch", "report", folder});
  EXPECT_EQ(report.exit_code, 0);
  EXPECT_NE(report.err.find("warning: "), std::string::npos) << report.err;
  EXPECT_NE(report.err.find("has changed since the plan was made"), std::string::npos);
  EXPECT_FALSE(std::filesystem::exists(folder + "/items"));
  EXPECT_TRUE(std::filesystem::exists(folder + "/report.html"));
}

TEST_F(Batch, ReportsDamagedSolutionAndSolvesItOnRequest) {
  const std::string folder = planned("damaged"), pack = folder + "/shards/1of1.solutions";
  EXPECT_EQ(run(folder, {"-j", "1"}).exit_code, 0);
  const std::string results = collected(folder), data = read_file(folder + "/dataset.h5");
  std::string bytes = read_file(pack);
  bytes.replace(bytes.size() / 2, 1, 1, static_cast<char>(bytes[bytes.size() / 2] ^ 1));
  folder_.write("damaged/shards/1of1.solutions", bytes);
  const ProcessResult collect = run_conddp({"batch", "collect", folder});
  EXPECT_NE(collect.err.find("warning: 1 solution cannot be read any more"), std::string::npos)
      << collect.err;
  int damaged = 0;
  for (const std::string& id : ids(folder)) {
    const ProcessResult show = run_conddp({"batch", "show", folder, id});
    if (show.exit_code == 0) continue;
    ++damaged;
    EXPECT_EQ(show.exit_code, 2);
    EXPECT_NE(show.err.find("the solution of " + id + " is damaged"), std::string::npos)
        << show.err;
  }
  EXPECT_EQ(damaged, 1);
  EXPECT_NE(run_conddp({"batch", "retry", folder, "failed"}).out.find("; 1 in "),
            std::string::npos);
  EXPECT_EQ(collected(folder), results);
  EXPECT_TRUE(read_file(folder + "/dataset.h5") == data);
}

TEST_F(Batch, LostPackIsSolvedAgainWithoutLosingData) {
  const std::string folder = planned("lost");
  EXPECT_EQ(run(folder).exit_code, 0);
  const std::string results = collected(folder), data = read_file(folder + "/dataset.h5");
  std::filesystem::remove(folder + "/shards/1of1.solutions");
  EXPECT_EQ(run_conddp({"batch", "status", folder}).exit_code, 1);
  collected(folder);
  EXPECT_TRUE(read_file(folder + "/dataset.h5") == data);
  EXPECT_EQ(run(folder).exit_code, 0);
  EXPECT_EQ(collected(folder), results);
  EXPECT_TRUE(read_file(folder + "/dataset.h5") == data);
}

TEST_F(Batch, ReportCountsItemsAndLinksOutliers) {
  const std::string folder = planned("report");
  const std::string variable = "CONDDP_BATCH_FAULT=crash:" + ids(folder)[4];
  EXPECT_EQ(run(folder, {}, {.environment = {variable}}).exit_code, 1);
  const ProcessResult r = run_conddp({"batch", "report", folder});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out, folder + "/report.html\n");
  const std::string page = read_file(folder + "/report.html");
  const std::string begin = "<script type=\"application/json\" id=\"report-data\">";
  const std::size_t first = page.find(begin) + begin.size();
  const auto data =
      nlohmann::json::parse(page.substr(first, page.find("</script>", first) - first));
  const auto& batch = data["batch"];
  EXPECT_EQ(batch["name"], "swings");
  EXPECT_EQ(batch["solved"], 29);
  EXPECT_EQ(batch["by_status"][1]["status"], "crashed");
  EXPECT_EQ(batch["lists"][0]["items"][0]["id"], ids(folder)[4]);
  // Slowest, lowest cost, and highest cost; the slowest may coincide with another.
  EXPECT_GE(data["solutions"].size(), 2u);
  const std::string elsewhere = folder_.path() / "pages/of/report.html";
  EXPECT_EQ(run_conddp({"batch", "report", folder, "-o", elsewhere}).exit_code, 0);
  EXPECT_TRUE(std::filesystem::exists(elsewhere));
  EXPECT_LE(data["solutions"].size(), 3u);
  for (const auto& list : batch["lists"])
    for (const auto& item : list["items"]) {
      EXPECT_EQ(item["files"].size(), item["status"] == "converged" ? 4u : 1u);
      for (const std::string file : item["files"])
        EXPECT_TRUE(std::filesystem::exists(folder + "/" + file)) << file;
    }
}

}  // namespace
}  // namespace conddp
