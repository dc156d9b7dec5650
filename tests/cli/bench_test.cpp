#include <cstdlib>
#include <set>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "child.hpp"
#include "process.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

/// Output of `bench --json` with one timed solve each.
Json bench(const Words& more, const std::string& problem = kPendulum) {
  Words arguments = {"bench", problem, "--repeat", "0", "--json"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const ProcessResult r = run_conddp(arguments);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  return Json::parse(r.out);
}

const Json& run_of(const Json& report, const std::string& solver) {
  for (const Json& run : report["runs"])
    if (run["solver"] == solver) return run;
  throw std::runtime_error("no run of " + solver);
}

TEST(Bench, HasEverySolverAndWritesItsTables) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"bench", kPendulum, "--repeat", "2", "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_TRUE(r.out.starts_with("pendulum_swingup (50 knots, 2 states, 1 controls)\n")) << r.out;
  for (const char* file : {"bench.json", "bench.csv", "bench.md", "profiles.gnuplot"})
    EXPECT_TRUE(std::filesystem::exists(folder.path() / "out" / file)) << file;
  const Json report = Json::parse(read_file(folder.path() / "out/bench.json"));
  ASSERT_EQ(report["runs"].size(), solvers().size());
  const std::string csv = read_file(folder.path() / "out/bench.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 1 + static_cast<int>(solvers().size()));
  const auto commas = std::count(csv.begin(), csv.begin() + csv.find('\n'), ',');
  std::istringstream lines(csv);
  for (std::string line; std::getline(lines, line);)
    EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas) << line;
  const std::string markdown = read_file(folder.path() / "out/bench.md");
  for (const SolverInfo& info : solvers()) {
    const std::string name(info.name);
    EXPECT_EQ(run_of(report, name)["seed"], nullptr);
    EXPECT_NE(r.out.find("\n  " + name + " "), std::string::npos) << r.out;
    EXPECT_NE(markdown.find("\n| " + name + " | "), std::string::npos) << markdown;
  }
  const Json& box = run_of(report, "box_ddp");
  EXPECT_EQ(box["status"], "converged");
  EXPECT_TRUE(box["solved"].get<bool>());
  EXPECT_EQ(box["time_s"]["solves"].size(), 2u);
  EXPECT_LE(box["residuals"]["stationarity"].get<double>(), 1e-5);
  EXPECT_EQ(run_of(report, "fddp")["status"], "refused");
  EXPECT_EQ(
      std::system((source("scripts/validate_json") + " " + source("schemas/bench.schema.json") +
                   " " + (folder.path() / "out/bench.json").string() + " >&2")
                      .c_str()),
      0);
}

TEST(Bench, DrawsProfilesOrReportsMissingGnuplot) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"bench", kPendulum, "--repeat", "0", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  if (std::system("command -v gnuplot >/dev/null") == 0) {
    EXPECT_EQ(r.err, "");
    EXPECT_NE(read_file(folder.path() / "profiles.svg").find("</svg>"), std::string::npos);
  }
  const ProcessResult without =
      run_conddp({"bench", kPendulum, "--repeat", "0", "-o", folder.path() / "without"},
                 {.environment = {"PATH=/nowhere"}});
  EXPECT_EQ(without.exit_code, 0) << without.err;
  EXPECT_NE(without.err.find("no profiles.svg: gnuplot is not installed"), std::string::npos)
      << without.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "without/profiles.svg"));
}

TEST(Bench, DropsConstraintsOnlyForUnsupportedSolvers) {
  for (const char* name : {"torque", "all"}) {
    const Json report = bench({"--drop", name});
    EXPECT_EQ(run_of(report, "box_ddp")["dropped_constraints"], Json::array());
    const Json& run = run_of(report, "fddp");
    EXPECT_NE(run["status"], "refused");
    ASSERT_EQ(run["dropped_constraints"].size(), 1u);
    EXPECT_EQ(run["dropped_constraints"][0]["name"], "torque");
    EXPECT_EQ(run["status"], "converged");
    EXPECT_FALSE(run["solved"].get<bool>());
    EXPECT_GT(run["dropped_constraints"][0]["violation"].get<double>(), 0);
    EXPECT_EQ(report["profiles"]["time"]["fddp"], Json::array());
  }
}

TEST(Bench, AutomaticChoiceIsANamedSolver) {
  const Json report = bench({"--solvers", "auto,box_fddp"});
  ASSERT_EQ(report["runs"].size(), 2u);
  const Json &chosen = run_of(report, "auto"), &same = run_of(report, "box_fddp");
  EXPECT_EQ(chosen["status"], "converged");
  EXPECT_TRUE(chosen["solved"].get<bool>());
  EXPECT_EQ(chosen["cost"], same["cost"]);
  EXPECT_EQ(chosen["iterations"], same["iterations"]);
  EXPECT_NE(chosen["command"].get<std::string>().find(" --solver auto"), std::string::npos);
}

TEST(Bench, FailuresStayInTheTable) {
  const Json report = bench({"--solvers", "box_ddp,box_fddp", "--set", "solver.max_iterations=2"});
  ASSERT_EQ(report["runs"].size(), 2u);
  EXPECT_EQ(report["runs"][0]["status"], "max_iterations");
  EXPECT_FALSE(report["runs"][0]["solved"].get<bool>());
  EXPECT_EQ(report["runs"][0]["options"],
            (Json{{"max_iterations", 2}, {"tolerances.stationarity", 1e-9}}));
  EXPECT_EQ(report["summary"][0]["failures"], (Json{{"max_iterations", 1}}));
}

TEST(Bench, TolerancesOfTheCommandLineHoldForAll) {
  const Json tight = bench({"--solvers", "box_ddp", "--tolerance", "stationarity=1e-9"});
  EXPECT_EQ(tight["runs"][0]["options"]["tolerances.stationarity"], 1e-9);
  EXPECT_LE(tight["runs"][0]["claimed_residuals"]["stationarity"].get<double>(), 1e-9);
}

/// Clock-independent part of the report.
Json answers(const Json& report) {
  Json list = Json::array();
  for (const Json& run : report["runs"])
    list.push_back({run["seed"], run["solver"], run["status"], run["iterations"], run["cost"]});
  return list;
}

TEST(Bench, InstancesFollowFromTheirSeeds) {
  const Words some = {"--solvers", "box_ddp,box_fddp", "--perturb", "initial_state=0.1"};
  const auto with = [&](const Words& more) {
    Words all = some;
    all.insert(all.end(), more.begin(), more.end());
    return answers(bench(all));
  };
  const Json three = with({"--instances", "3"});
  ASSERT_EQ(three.size(), 6u);
  EXPECT_EQ(three, with({"--instances", "3"}));
  EXPECT_EQ(three[0][0], 1);
  EXPECT_EQ(three[5][0], 3);
  EXPECT_NE(three[0][4], three[2][4]);
  const Json third = with({"--instances", "1", "--seed", "3"});
  EXPECT_EQ(third, (Json{three[4], three[5]}));
}

/// A report without its times.
Json without_times(Json report) {
  for (Json& run : report["runs"]) run.erase("time_s");
  report["profiles"].erase("time");
  return report;
}

TEST(Bench, AnswersIgnoreTheNumberOfParallelSolves) {
  const auto with = [&](const char* jobs) {
    return without_times(bench({"--solvers", "box_ddp,ipopt", "--perturb", "initial_state=0.1",
                                "--perturb", "guess=0.1", "--instances", "6", "-j", jobs}));
  };
  const Json alone = with("1");
  ASSERT_EQ(alone["runs"].size(), 12u);
  EXPECT_EQ(with("2"), alone);
  EXPECT_EQ(with("5"), alone);
}

TEST(Bench, CountsTheWholeHomotopy) {
  const std::string weaker = "solver.homotopy=[{key: constraints.torque.upper, from: 12, to: 3}]";
  const Words one = {"--solvers", "box_ddp"};
  const Words along = {"--solvers", "box_ddp", "--set", weaker};
  const Words instance = {"--solvers", "box_ddp",   "--set",
                          weaker,      "--perturb", "initial_state=0.1"};
  const Json plain = bench(one)["runs"][0], way = bench(along)["runs"][0];
  EXPECT_EQ(way["status"], "converged");
  EXPECT_GT(way["iterations"], plain["iterations"]);
  EXPECT_EQ(bench(instance)["runs"][0]["status"], "converged");
}

TEST(Bench, GuessesFollowFromTheirSeedsToo) {
  const Words two = {"--solvers", "box_fddp", "--perturb", "guess=0.1", "--instances", "2"};
  const Json report = bench(two);
  EXPECT_EQ(report["request"]["perturb"], (Json{{"initial_state", 0.0}, {"guess", 0.1}}));
  const Json runs = answers(report);
  EXPECT_EQ(runs, answers(bench(two)));
  // The same problem from elsewhere: another route to the same optimum.
  ASSERT_EQ(runs.size(), 2u);
  const Json unperturbed = answers(bench({"--solvers", "box_fddp"}));
  for (const Json& run : runs)
    EXPECT_NEAR(run[4].get<double>(), unperturbed[0][4].get<double>(), 1e-6);
  EXPECT_NE(runs[0][4], runs[1][4]);
  Words both = two;
  both.insert(both.end(), {"--perturb", "initial_state=0.1"});
  EXPECT_NE(answers(bench(both))[0][4], runs[0][4]);
}

// One benchmark instance solved alone: bitwise equal cost and a verified answer.
TEST(Bench, AnInstanceIsSolvedAloneByItsSeed) {
  const Json report = bench({"--solvers", "box_ddp", "--perturb", "initial_state=0.1", "--perturb",
                             "guess=0.2", "--seed", "5"});
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", kPendulum, "--solver", "box_ddp", "--perturb", "initial_state=0.1",
                  "--perturb", "guess=0.2", "--seed", "5", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const Json solution = Json::parse(read_file(folder.path() / "solution.json"));
  EXPECT_EQ(solution["cost"], report["runs"][0]["cost"]);
  EXPECT_EQ(solution["iterations"], report["runs"][0]["iterations"]);
  EXPECT_NE(solution["trajectory"]["x"][0][0], 0);
  const ProcessResult verified = run_conddp({"verify", folder.path() / "solution.json"});
  EXPECT_EQ(verified.exit_code, 0) << verified.out;
  // The same as file settings.
  const ProcessResult set = run_conddp({"solve", kPendulum, "--solver", "box_ddp", "--set",
                                        "perturbation={initial_state: 0.1, guess: 0.2, seed: 5}",
                                        "-o", folder.path() / "set"});
  EXPECT_EQ(set.exit_code, 0) << set.err;
  EXPECT_EQ(Json::parse(read_file(folder.path() / "set/solution.json"))["cost"], solution["cost"]);
  EXPECT_EQ(run_conddp({"solve", kPendulum, "--seed", "5"}).exit_code, 2) << "of what?";
}

/// Solution of a run's command, executed by a shell unchanged.
Json solution_of(const Json& run, const TemporaryFolder& folder) {
  const std::string command = run["command"];
  EXPECT_TRUE(command.starts_with("conddp solve ")) << command;
  const std::string line = "cd '" + folder.path().string() + "' && " + conddp_binary() +
                           command.substr(6) + " --quiet -o answer >/dev/null 2>&1";
  const int status = std::system(line.c_str());
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) < 2) << line;
  return Json::parse(read_file(folder.path() / "answer/solution.json"));
}

// Every benchmark run repeated by its command: bitwise equal, failures included.
TEST(Bench, ItsCommandsSolveItsRunsAgain) {
  const TemporaryFolder folder;
  std::string text = read_file(kPendulum);
  text.erase(0, text.find("conddp: 1"));
  folder.write("it's a pendulum.yaml",
               text + "perturbation: {initial_state: 0.2, guess: 0.1, seed: 3}\n");
  const Words common = {"bench",
                        "it's a pendulum.yaml",
                        "--repeat",
                        "0",
                        "--json",
                        "--solvers",
                        "ilqr_clip,box_ddp,fddp,altro,ipopt"};
  const std::vector<Words> requests = {
      {},
      {"--drop", "torque"},
      {"--set", "solver={name: ipopt, max_iterations: 30}", "--tolerance", "stationarity=1.5e-7"},
      {"--perturb", "initial_state=0.3", "--perturb", "guess=0.25", "--seed", "8"},
      {"--perturb", "guess=0.3", "--instances", "2", "--drop", "all"}};
  int compared = 0;
  for (const Words& more : requests) {
    Words words = common;
    words.insert(words.end(), more.begin(), more.end());
    const ProcessResult r = run_conddp(words, {.folder = folder.path()});
    ASSERT_EQ(r.exit_code, 0) << r.err;
    const Json report = Json::parse(r.out);
    for (const Json& run : report["runs"]) {
      if (run["status"] == "refused") continue;
      const Json solution = solution_of(run, folder);
      EXPECT_EQ(solution["cost"], run["cost"]) << run["command"];
      EXPECT_EQ(solution["iterations"], run["iterations"]) << run["command"];
      EXPECT_EQ(solution["status"], run["status"]) << run["command"];
      EXPECT_EQ(solution["trajectory"]["x"][0], run["initial_state"]) << run["command"];
      ++compared;
    }
  }
  EXPECT_EQ(compared, 4 + 5 + 4 + 4 + 10);
}

TEST(Bench, ExplainsHowToReproduceFailures) {
  const ProcessResult r = run_conddp({"bench", kPendulum, "--solvers", "box_ddp,fddp", "--repeat",
                                      "0", "--set", "solver.max_iterations=2"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("\n    conddp solve " + kPendulum +
                       " --solver box_ddp --set solver.max_iterations=2\n"),
            std::string::npos)
      << r.out;
  EXPECT_EQ(r.out.find("--solver fddp"), std::string::npos) << "a refusal needs no second look";
}

TEST(Bench, ComparesWithBestKnownOptimum) {
  const TemporaryFolder folder;
  const std::string text = read_file(kPendulum);
  folder.write("pendulum.yaml", text);
  const auto run = [&](const Words& more = {}) {
    Words words = {"bench", "pendulum.yaml", "--solvers", "box_ddp,fddp", "--repeat",
                   "0",     "--json"};
    words.insert(words.end(), more.begin(), more.end());
    const ProcessResult r = run_conddp(words, {.folder = folder.path()});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    return Json::parse(r.out);
  };
  const Json unknown = run()["runs"][0];
  EXPECT_EQ(unknown["best_known"], nullptr);
  EXPECT_EQ(unknown["cost_excess"], nullptr);
  const auto know = [&](double cost) {
    folder.write(
        "best_known.json",
        Json{{"format", "conddp.best_known/1"},
             {"problems",
              {{"pendulum", {{"problem_sha256", unknown["problem_sha256"]}, {"cost", cost}}}}}}
            .dump());
  };
  const double cost = unknown["cost"];
  know(0.8 * cost);
  const Json above = run();
  EXPECT_EQ(above["runs"][0]["best_known"], 0.8 * cost);
  EXPECT_NEAR(above["runs"][0]["cost_excess"].get<double>(), 0.25, 1e-12);
  EXPECT_EQ(above["summary"][0]["within"], (Json{{"1e-6", 0}, {"1e-3", 0}, {"1e-1", 0}}));
  // Another guess leaves the problem unchanged; another initial state, a dropped constraint, or
  // other costs do not.
  EXPECT_EQ(run({"--perturb", "guess=0.1"})["runs"][0]["best_known"], 0.8 * cost);
  EXPECT_EQ(run({"--set", "solver.max_iterations=99"})["runs"][0]["best_known"], 0.8 * cost);
  EXPECT_EQ(run({"--perturb", "initial_state=0.1"})["runs"][0]["best_known"], nullptr);
  EXPECT_EQ(run({"--drop", "torque"})["runs"][0]["best_known"], 0.8 * cost);
  EXPECT_EQ(run({"--drop", "torque"})["runs"][1]["best_known"], nullptr);
  EXPECT_EQ(run({"--set", "constraints.torque.upper=2.5"})["runs"][0]["best_known"], nullptr);
  know(2 * cost);
  EXPECT_EQ(run()["summary"][0]["within"], (Json{{"1e-6", 1}, {"1e-3", 1}, {"1e-1", 1}}));
  const ProcessResult better =
      run_conddp({"bench", "pendulum.yaml", "--solvers", "box_ddp"}, {.folder = folder.path()});
  EXPECT_NE(better.out.find("is less than the best known cost, "), std::string::npos) << better.out;
}

TEST(Bench, FolderMeansItsProblemsWithASummary) {
  const TemporaryFolder folder;
  std::string text = read_file(kPendulum);
  const std::size_t name = text.find("pendulum_swingup\n");
  ASSERT_NE(name, std::string::npos);
  for (const std::string letter : {"a", "b"})
    folder.write(letter + ".yaml", std::string(text).replace(name, 16, letter));
  folder.write("notes.txt", "no problem");
  const ProcessResult r =
      run_conddp({"bench", folder.path(), "--solvers", "box_fddp", "--repeat", "0"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_TRUE(r.out.starts_with("a (50 knots")) << r.out;
  EXPECT_NE(r.out.find("\nb (50 knots"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("\nall problems\n"), std::string::npos) << r.out;
}

}  // namespace
}  // namespace conddp
