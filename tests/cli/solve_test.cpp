#include <cstdlib>
#include <fstream>
#include <set>

#include <signal.h>
#include <sys/stat.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "long_problem.hpp"
#include "process.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;
using Files = std::vector<std::string>;

const Files kOutputs = {"iterations.csv", "solution.json", "trajectory.csv"};

TEST(Solve, ConvergesAndWritesItsFiles) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"solve", kPendulum, "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err, "");
  EXPECT_NE(r.out.find("pendulum_swingup: converged (box_ddp, "), std::string::npos) << r.out;
  EXPECT_EQ(r.out.find('\033'), std::string::npos);
  EXPECT_EQ(folder.files(),
            (Files{"out/iterations.csv", "out/solution.json", "out/trajectory.csv"}));
  const Json solution = Json::parse(read_file(folder.path() / "out/solution.json"));
  EXPECT_EQ(solution["status"], "converged");
  EXPECT_EQ(solution["problem"]["sha256"].get<std::string>().size(), 64u);
}

TEST(Solve, CertificateOfAnInfeasibleAnswerHolds) {
  // Output after the last multiplier update uses these multipliers.
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", source("problems/double_integrator_limits.yaml"), "--set",
                  "terminal.constraints.goal.reference=[9, 0]", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_NE(r.out.find("infeasible"), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("certificate   consistency check passed"), std::string::npos) << r.out;
}

// Torques without cost: the torques that hold a biped on two feet are not unique.
TEST(Solve, ExitsWithOneIfOptimalityIsInDoubt) {
  const TemporaryFolder folder;
  const ProcessResult result =
      run_conddp({"solve", source("problems/biped_squat.yaml"), "-o", folder.path() / "out",
                  "--set", "costs.effort.weight=0"});
  EXPECT_EQ(result.exit_code, 1) << result.err;
  EXPECT_NE(result.err.find("its optimality cannot be decided"), std::string::npos);
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "out/solution.json"));
}

TEST(Solve, EndsAtASettledCostIfRequested) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", kPendulum, "--set", "solver.tolerances.stationarity=1e-12", "--set",
                  "solver.tolerances.cost_decrease=0.01", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find(": cost_settled ("), std::string::npos) << r.out;
  EXPECT_EQ(r.out.find("try  "), std::string::npos) << r.out;
  const std::string solution = folder.path() / "solution.json";
  EXPECT_EQ(run_conddp({"verify", solution}).exit_code, 0);
  std::string text = read_file(solution);
  const std::size_t status = text.find("\"cost_settled\"");
  ASSERT_NE(status, std::string::npos);
  std::ofstream(solution) << text.replace(status, 14, "\"converged\"");
  EXPECT_EQ(run_conddp({"verify", solution}).exit_code, 1) << "it is not stationary";
}

// Without a solver name, the problem determines the solver, and check reports it.
TEST(Solve, SolvesAFileWithoutASolverName) {
  const TemporaryFolder folder;
  std::string text = read_file(source("problems/double_integrator_limits.yaml"));
  const std::string line = "solver: {name: altro, tolerances: {constraint: 1.0e-8}}";
  ASSERT_NE(text.find(line), std::string::npos);
  text.erase(text.find(line));
  const std::filesystem::path file = folder.path() / "limits.yaml";
  std::ofstream(file) << text;
  const ProcessResult check = run_conddp({"check", file});
  EXPECT_NE(check.out.find("solver          altro ("), std::string::npos) << check.out;
  EXPECT_NE(check.out.find("where that does not converge: proxddp, ipopt"), std::string::npos);
  const ProcessResult solve = run_conddp({"solve", "-v", file, "-o", folder.path() / "out"});
  EXPECT_EQ(solve.exit_code, 0);
  const std::string why =
      "altro, since there are constraints besides bounds on the control; then proxddp, ipopt";
  EXPECT_NE(solve.out.find("auto          " + why), std::string::npos) << solve.out;
  EXPECT_NE(solve.err.find("auto: " + why), std::string::npos) << solve.err;
  const Json solution = Json::parse(read_file(folder.path() / "out/solution.json"));
  EXPECT_EQ(solution["solver"], "altro");
  EXPECT_EQ(run_conddp({"verify", folder.path() / "out/solution.json"}).exit_code, 0);
}

TEST(Solve, AutoRestartsWhenAllSolversFail) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", source("tests/golden/hard/arm_at_limits.yaml"), "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  EXPECT_NE(r.out.find("  restarts      "), std::string::npos) << r.out;
  const Json solution = Json::parse(read_file(folder.path() / "solution.json"));
  EXPECT_EQ(solution["status"], "converged");
  EXPECT_GE(solution["restarts"]["converged"], 1);
  EXPECT_GE(solution["restarts"]["answer"], 1);
  const std::string message = solution["message"];
  EXPECT_NE(message.find(" ended as "), std::string::npos) << message;
  EXPECT_NE(message.find(" from restart "), std::string::npos) << message;
  EXPECT_EQ(run_conddp({"verify", folder.path() / "solution.json"}).exit_code, 0);
}

TEST(Solve, MotionIsIndependentOfCostUnits) {
  const TemporaryFolder folder;
  const auto run = [&](const char* name, std::vector<std::string> settings) {
    std::vector<std::string> arguments{"solve", source("problems/cartpole_goal.yaml"), "-o",
                                       folder.path() / name};
    for (std::string& setting : settings) {
      arguments.emplace_back("--set");
      arguments.push_back(std::move(setting));
    }
    EXPECT_EQ(run_conddp(arguments).exit_code, 0);
    EXPECT_EQ(run_conddp({"verify", folder.path() / name / "solution.json"}).exit_code, 0);
    return Json::parse(read_file(folder.path() / name / "solution.json"));
  };
  const Json usual = run("usual", {}),
             small = run("small", {"costs.effort.weight=1e-10", "costs.state.weight=1e-11",
                                   "terminal.costs.state.weight=1e-7"});
  EXPECT_FALSE(usual.contains("cost_scale"));
  EXPECT_GT(small["cost_scale"].get<double>(), 1e6);
  EXPECT_NEAR(1e9 * small["cost"].get<double>(), usual["cost"].get<double>(), 1e-6);
  Json forged = small;
  forged["cost_scale"] = 1;
  std::ofstream(folder.path() / "forged.json") << forged.dump();
  EXPECT_EQ(run_conddp({"verify", folder.path() / "forged.json"}).exit_code, 1);
}

TEST(Solve, ReportsFreePhaseDurations) {
  const TemporaryFolder folder;
  // Rest-to-rest motion in minimum time, 4 s, with an additional growing state.
  const std::string file = folder.write("quick.yaml", R"(conddp: 1
system: {states: [x, v], controls: [u], rate: {x: v, v: u}}
initial_state: {}
phases:
  - {choose: none}
  - {name: push, knots: 10, duration: 0.8, free_duration: {lower: 0.1, upper: 5}}
  - {name: pull, knots: 10, duration: 0.8, free_duration: {lower: 0.1, upper: 5}}
integrals: {effort: u^2}
costs: {time: {residual: expression, rows: 1, activation: linear}}
constraints:
  forth: {bounds: control, lower: 0, upper: 1, phases: push}
  back: {bounds: control, lower: -1, upper: 0, phases: pull}
terminal: {constraints: {there: {residual: state, columns: [x, v], reference: [4, 0]}}}
)");
  const ProcessResult r = run_conddp({"solve", file, "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const std::size_t line = r.out.find("  durations     push ");
  ASSERT_NE(line, std::string::npos) << r.out;
  double push = 0, pull = 0;
  ASSERT_EQ(
      std::sscanf(r.out.c_str() + line, "  durations     push %lf s, pull %lf s", &push, &pull), 2);
  EXPECT_NEAR(push, 2, 1e-6);
  EXPECT_NEAR(pull, 2, 1e-6);
}

TEST(Solve, SummaryAndHeadTellFreeParameters) {
  const TemporaryFolder folder;
  // The lightest mass needs the least force.
  const std::string file = folder.write("light.yaml", R"(conddp: 1
parameters: {mass: {free: true, lower: 0.5, upper: 2}}
system: {states: {x: m, v: m/s}, controls: {f: N}, rate: {x: v, v: f/mass}}
initial_state: {values: {x: 0}}
phases: [{name: go, knots: 10, duration: 1}]
costs: {effort: {residual: control}}
terminal: {constraints: {there: {residual: state, columns: [x, v], reference: [1, 0]}}}
solver: {name: altro}
)");
  const ProcessResult r = run_conddp({"solve", file, "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("  parameters    mass 0.5 (its lower limit)\n"), std::string::npos) << r.out;
  const auto document = nlohmann::json::parse(read_file(folder.path() / "out/solution.json"));
  const auto& mass = document["free_numbers"][0];
  EXPECT_EQ(mass["name"], "mass");
  EXPECT_EQ(mass["limit"], "lower");
  EXPECT_NEAR(mass["value"].get<double>(), 0.5, 1e-9);
}

TEST(Solve, FormatsSelectTheFiles) {
  const TemporaryFolder folder;
  const auto solve = [&](const std::string& formats) {
    return run_conddp({"solve", kPendulum, "-o", folder.path(), "--output-format", formats});
  };
  const auto files = [&] {
    std::set<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
      names.insert(entry.path().filename());
    return names;
  };
  EXPECT_EQ(solve("json,csv,npz").exit_code, 0);
  EXPECT_EQ(files(), (std::set<std::string>{"iterations.csv", "solution.json", "trajectory.csv",
                                            "trajectory.npz"}));
  EXPECT_EQ(solve("npz").exit_code, 0);
  EXPECT_EQ(files(), std::set<std::string>{"trajectory.npz"});
  for (const char* list : {"", "hdf5", "json,", "json;csv"}) {
    const ProcessResult r = solve(list);
    EXPECT_EQ(r.exit_code, 2) << list;
    EXPECT_NE(r.err.find("--output-format"), std::string::npos) << r.err;
  }
  EXPECT_EQ(files(), std::set<std::string>{"trajectory.npz"});
}

TEST(Solve, DefaultFolderHasTheNameOfTheProblem) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"solve", kPendulum, "--quiet"}, {.folder = folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out + r.err, "");
  EXPECT_TRUE(std::filesystem::exists(folder.path() / "out/pendulum_swingup/solution.json"));
}

TEST(Solve, JsonOnStdoutIsTheSolutionHeader) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"solve", kPendulum, "--json", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const Json head = Json::parse(r.out);
  EXPECT_EQ(head["status"], "converged");
  EXPECT_FALSE(head.contains("trajectory"));
}

TEST(Solve, TheSolutionFitsItsSchema) {
  const TemporaryFolder folder;
  for (const std::string problem : {"pendulum_swingup", "arm_reach", "car_parking"})
    run_conddp({"solve", source("problems/" + problem + ".yaml"), "-o", folder.path() / problem,
                "--max-time", "20"});
  run_conddp({"solve", source("problems/arm_reach.yaml"), "--drop", "torque", "--solver", "fddp",
              "--set", "initial_guess.controls={random: {seed: 3, scale: 0.1}}", "-o",
              folder.path() / "dropped"});
  std::string command =
      source("scripts/validate_json") + " " + source("schemas/solution.schema.json");
  for (const std::string& file : folder.files())
    if (file.ends_with(".json")) command += " " + (folder.path() / file).string();
  EXPECT_EQ(std::system((command + " >&2").c_str()), 0);
}

TEST(Solve, ReportsDroppedConstraints) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp(
      {"solve", source("problems/arm_reach.yaml"), "--drop", "torque", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("dropped       torque: violated by"), std::string::npos) << r.out;
  const Json solution = Json::parse(read_file(folder.path() / "solution.json"));
  EXPECT_EQ(solution["dropped_constraints"][0]["name"], "torque");
  EXPECT_GT(solution["dropped_constraints"][0]["violation"].get<double>(), 0);
}

TEST(Solve, ExitsWithOneIfNotConverged) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", kPendulum, "--set", "solver.max_iterations=2", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_EQ(folder.files(), kOutputs);
  EXPECT_NE(r.out.find("max_iterations"), std::string::npos);
}

TEST(Solve, StopsAtTheTimeLimit) {
  const TemporaryFolder folder;
  const std::string problem = folder.write("long.yaml", kLong);
  const ProcessResult r =
      run_conddp({"solve", problem, "--max-time", "0.2", "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_EQ(Json::parse(read_file(folder.path() / "out/solution.json"))["status"], "time_limit");
}

TEST(Solve, NonFiniteNumbersAreNotAnInternalError) {
  // Far from the world's origin, an inertia of 1 kg m² vanishes against m r².
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"solve", source("problems/cartpole_swingup.yaml"), "--set",
                                      "initial_state.joints.slider=1e8", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 1) << r.err;
  EXPECT_EQ(folder.files(), kOutputs);
  EXPECT_EQ(r.err.find("defect"), std::string::npos) << r.err;
}

TEST(Solve, SignalsKeepTheBestIterate) {
  for (const int number : {SIGINT, SIGTERM}) {
    const TemporaryFolder folder;
    const std::string problem = folder.write("long.yaml", kLong);
    const ProcessResult r = run_conddp({"solve", problem, "-v", "-o", folder.path() / "out"},
                                       {.signal = number, .signal_after = "\n    1 "});
    EXPECT_EQ(r.exit_code, 128 + number) << r.err;
    EXPECT_EQ(Json::parse(read_file(folder.path() / "out/solution.json"))["status"], "interrupted");
  }
}

TEST(Solve, InterruptedIpoptWritesWholeFilesAndACertificate) {
  const TemporaryFolder folder;
  const std::string problem = source("problems/acrobot_swingup.yaml");
  const ProcessResult r =
      run_conddp({"solve", problem, "--solver", "ipopt", "-v", "-o", folder.path() / "out"},
                 {.signal = SIGINT, .signal_after = "\n    3 "});
  EXPECT_EQ(r.exit_code, 128 + SIGINT) << r.err;
  EXPECT_EQ(Json::parse(read_file(folder.path() / "out/solution.json"))["status"], "interrupted");
  EXPECT_EQ(run_conddp({"verify", folder.path() / "out/solution.json"}).exit_code, 0);
  const ProcessResult late = run_conddp(
      {"solve", problem, "--solver", "ipopt", "--max-time", "0.001", "-o", folder.path() / "late"});
  EXPECT_EQ(late.exit_code, 1) << late.err;
  EXPECT_EQ(run_conddp({"verify", folder.path() / "late/solution.json"}).exit_code, 0);
}

TEST(Solve, IpoptUsesCurvatureOfCostStateMotions) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", source("problems/collection/hypersensitive.yaml"), "--solver", "ipopt",
                  "--set", "solver.max_iterations=20", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
  const Json solution = Json::parse(read_file(folder.path() / "solution.json"));
  EXPECT_NEAR(solution["cost"].get<double>(), 1.3308069, 1e-4);
}

/// Options on the initial point or barrier activate Ipopt's own start, which converges slowly here;
/// other options do not.
TEST(Solve, IpoptUsesItsOwnStartForInitializationOptions) {
  const TemporaryFolder folder;
  for (const std::string option : {"mu_init", "bound_push", "slack_bound_frac"}) {
    const ProcessResult r =
        run_conddp({"solve", source("problems/collection/hypersensitive.yaml"), "--solver", "ipopt",
                    "--set", "solver.max_iterations=20", "--set",
                    "solver.options={" + option + ": 0.1}", "-o", folder.path()});
    EXPECT_EQ(r.exit_code, 1) << option << r.out << r.err;
  }
  const ProcessResult r = run_conddp({"solve", source("problems/collection/hypersensitive.yaml"),
                                      "--solver", "ipopt", "--set", "solver.max_iterations=20",
                                      "--set", "solver.options={max_soc: 3}", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.out << r.err;
}

TEST(Solve, WarmStartFromOwnSolutionIsQuick) {
  const TemporaryFolder folder;
  run_conddp({"solve", kPendulum, "-o", folder.path()});
  for (const std::string file : {"solution.json", "trajectory.csv"}) {
    const ProcessResult r =
        run_conddp({"solve", kPendulum, "--set",
                    "initial_guess={file: " + (folder.path() / file).string() + "}", "--json", "-o",
                    folder.path() / "warm"});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_LE(Json::parse(r.out)["iterations"], 1) << file;
  }
}

TEST(Solve, ReportsThePathOfAHomotopy) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", kPendulum, "-o", folder.path() / "out", "-v", "--set",
                  "solver.homotopy=[{key: constraints.torque.lower, from: -12, to: -3}, {key: "
                  "constraints.torque.upper, from: 12, to: 3}]"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("  homotopy      iterations at s = 0: "), std::string::npos) << r.out;
  EXPECT_NE(r.out.find("certificate   certified local minimum"), std::string::npos) << r.out;
  EXPECT_NE(r.err.find("homotopy at s = 0.25\n"), std::string::npos) << r.err;
  const std::string file = folder.path() / "out/solution.json";
  const Json solution = Json::parse(read_file(file));
  EXPECT_EQ(solution["homotopy"].back()["share"], 1);
  EXPECT_EQ(solution["log"].front()["homotopy"], 0);
  int iterations = 0;
  for (const Json& step : solution["homotopy"]) iterations += step["iterations"].get<int>();
  EXPECT_EQ(solution["iterations"], iterations);
  EXPECT_EQ(run_conddp({"verify", file}).exit_code, 0);
  EXPECT_TRUE(fits_schema("solution", read_file(file)));
}

TEST(Solve, ListsTheOptimaOfRestarts) {
  const TemporaryFolder folder;
  const std::string file = folder.path() / "solution.json";
  const ProcessResult r =
      run_conddp({"solve", source("problems/acrobot_goal.yaml"), "--set",
                  "solver.restarts={count: 6, spread: 5}", "--threads", "2", "-o", folder.path()});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("  restarts      7 starts, "), std::string::npos) << r.out;
  const Json restarts = Json::parse(read_file(file))["restarts"];
  EXPECT_EQ(restarts["starts"], 7);
  int converged = 0;
  for (const Json& optimum : restarts["optima"]) converged += optimum["starts"].get<int>();
  EXPECT_EQ(restarts["converged"], converged);
  EXPECT_GE(restarts["optima"].size(), 2u) << "the acrobot's two ways to swing up";
  EXPECT_EQ(run_conddp({"verify", file}).exit_code, 0);
  EXPECT_TRUE(fits_schema("solution", read_file(file)));
}

TEST(Solve, ResultsIgnoreTheThreadCount) {
  const TemporaryFolder folder;
  const std::string problem = source("problems/arm_reach.yaml");
  for (const std::string n : {"1", "2", "3"})
    EXPECT_EQ(run_conddp({"solve", problem, "--threads", n, "-o", folder.path() / n}).exit_code, 0);
  const std::string one = read_file(folder.path() / "1/trajectory.csv");
  EXPECT_EQ(one, read_file(folder.path() / "2/trajectory.csv"));
  EXPECT_EQ(one, read_file(folder.path() / "3/trajectory.csv"));
}

TEST(Solve, FullDiskKeepsTheFormerOutput) {
  const TemporaryFolder folder;
  run_conddp({"solve", kPendulum, "-o", folder.path()});
  const std::string before = read_file(folder.path() / "solution.json");
  const ProcessResult r =
      run_conddp({"solve", kPendulum, "-o", folder.path(), "--solver", "ilqr_clip"},
                 {.limit_file_size = 3000});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("solution.json' cannot be written"), std::string::npos) << r.err;
  EXPECT_EQ(folder.files(), kOutputs);
  EXPECT_EQ(read_file(folder.path() / "solution.json"), before);
}

TEST(Solve, NamesOutputFoldersThatCannotBeCreated) {
  const TemporaryFolder folder;
  const std::string file = folder.write("file", "");
  const ProcessResult r = run_conddp({"solve", kPendulum, "-o", file + "/out"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("cannot be made"), std::string::npos) << r.err;
}

// Certificate and files of this many knots take most of a second.
TEST(Solve, WritesInterruptedAnswersOfLongHorizons) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", kPendulum, "--set", "phases.0.knots=40000", "-v", "-o", folder.path()},
                 {.signal = SIGINT, .signal_after = "\n    0 "});
  EXPECT_EQ(r.exit_code, 128 + SIGINT) << r.err;
  EXPECT_EQ(r.err.find("there was no time"), std::string::npos) << r.err;
  EXPECT_EQ(folder.files(), kOutputs);
}

// Certificate and files of this many knots far exceed the five seconds after a signal.
TEST(Solve, OmitsInterruptedAnswersThatTakeTooLong) {
  const TemporaryFolder folder;
  const ProcessResult r =
      run_conddp({"solve", kPendulum, "--set", "phases.0.knots=1000000", "-v", "-o", folder.path()},
                 {.signal = SIGTERM, .signal_after = "\n    0 "});
  EXPECT_EQ(r.exit_code, 128 + SIGTERM) << r.err;
  EXPECT_NE(r.err.find("conddp: interrupted; there was no time to write an answer\n"),
            std::string::npos)
      << r.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "solution.json"));
}

TEST(Solve, TooShortTimeLimitsNameTheKnots) {
  const TemporaryFolder folder;
  const ProcessResult r = run_conddp({"solve", kPendulum, "--set", "phases.0.knots=1000000",
                                      "--max-time", "1.5", "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("after a solve of 1000000 knots"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("--set:1:16: error"), std::string::npos) << r.err;
  EXPECT_FALSE(std::filesystem::exists(folder.path() / "out"));
}

// A winding with a time constant of a microsecond in steps of ten milliseconds.
TEST(Solve, NamesLongStepsIfNumbersOverflow) {
  const TemporaryFolder folder;
  const std::string file = folder.write("stiff.yaml", R"(conddp: 1
system: {states: {i: A}, controls: {V: V}, rate: {i: 1.0e+6*(V - i)}}
initial_state: {values: {i: 0}}
phases: [{knots: 20, dt: 0.01}]
costs: {track: {residual: state, reference: [1]}, effort: {residual: control, weight: 1.0e-3}}
)");
  const ProcessResult r = run_conddp({"solve", file, "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 1);
  const std::string all = r.out + r.err;
  EXPECT_NE(all.find("the system is stiff for steps of rk4"), std::string::npos) << all;
  EXPECT_EQ(all.find("-nan"), std::string::npos) << all;
  EXPECT_EQ(read_file(folder.path() / "out/solution.json").find("nan"), std::string::npos);
}

TEST(Solve, AdvisesImpulsesWhereGaitsTouchDown) {
  const TemporaryFolder folder;
  const std::filesystem::path trot = source_tree() / "problems/quadruped_trot.yaml";
  const std::string advice = "try an impulse ('gait: {impulses: true}'";
  const ProcessResult soft = run_conddp({"solve", trot, "-o", folder.path() / "soft"});
  EXPECT_NE(soft.out.find(advice), std::string::npos) << soft.out;
  const ProcessResult hard = run_conddp({"solve", trot, "-o", folder.path() / "hard", "--set",
                                         "gait.impulses=true", "--set", "integrator=rk4"});
  EXPECT_EQ(hard.out.find("the grid does not resolve"), std::string::npos) << hard.out;
  EXPECT_EQ(hard.out.find("drifts"), std::string::npos) << hard.out;
}

TEST(Solve, NamesStatesWithUndefinedEquations) {
  const TemporaryFolder folder;
  const std::string file = folder.write("rest.yaml", R"(conddp: 1
system: {states: {v: m/s, angle: rad}, controls: {T: N}, rate: {v: T - v, angle: -cos(angle)/v}}
initial_state: {values: {v: 0}}
phases: [{knots: 20, dt: 0.01}]
costs: {track: {residual: state, reference: {values: {v: 1}}}, effort: {residual: control}}
)");
  const ProcessResult r = run_conddp({"solve", file, "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_NE(r.out.find("the rate of 'angle' is not finite there, but would be with another 'v'"),
            std::string::npos)
      << r.out;
  EXPECT_NE(r.out.find("try           'v: 0.1' in the initial state"), std::string::npos) << r.out;
  EXPECT_EQ(r.out.find("the grid does not resolve"), std::string::npos) << r.out;
  const ProcessResult moved = run_conddp(
      {"solve", file, "-o", folder.path() / "moved", "--set", "initial_state.values={v: 0.1}"});
  EXPECT_EQ(moved.exit_code, 0) << moved.out << moved.err;
}

TEST(Solve, NamesViolatedRowsWithTheirExpressions) {
  const TemporaryFolder folder;
  const std::string file = folder.write("rows.yaml", R"(conddp: 1
system: {states: {x: m}, controls: {u: m/s}, rate: {x: u}}
initial_state: {values: {x: 0}}
phases: [{knots: 10, dt: 0.1}]
costs: {effort: {residual: control}}
constraints: {slow: {bounds: control, lower: -1, upper: 1}}
terminal: {constraints: {end: {residual: expression, rows: [x, x^2 + x], lower: [-2, 5], upper: 6}}}
)");
  const ProcessResult r = run_conddp({"solve", file, "-o", folder.path() / "out"});
  EXPECT_EQ(r.exit_code, 1);
  EXPECT_NE(r.out.find("'terminal/end' is violated by 3 by row 2, x^2 + x (knot 10, 1 s)"),
            std::string::npos)
      << r.out;
  EXPECT_EQ(r.out.find("by row 1"), std::string::npos) << r.out;
  EXPECT_TRUE(fits_schema("solution", read_file(folder.path() / "out/solution.json")));
}

// The same findings in the summaries of solve and verify and in their documents.
TEST(Solve, ReportsFindingsOfTheMotion) {
  const TemporaryFolder folder;
  const auto run = [&](std::vector<std::string> arguments) {
    return run_conddp(std::move(arguments), {.folder = folder.path()});
  };
  const ProcessResult solved = run({"solve", source("problems/quadruped_trot.yaml"), "--set",
                                    "contacts.defaults.baumgarte.kd=20", "-o", "out"});
  EXPECT_EQ(solved.exit_code, 0) << solved.err;
  EXPECT_NE(solved.out.find("  findings      the contact '"), std::string::npos) << solved.out;
  EXPECT_NE(solved.out.find("baumgarte: {kd: 50}"), std::string::npos) << solved.out;
  const std::string document = read_file(folder.path() / "out/solution.json");
  EXPECT_TRUE(fits_schema("solution", document));
  const ProcessResult verified = run({"verify", "out/solution.json"});
  EXPECT_EQ(verified.exit_code, 0) << verified.out;
  EXPECT_NE(verified.out.find("\n  finding the contact '"), std::string::npos) << verified.out;
  const ProcessResult json = run({"verify", "out/solution.json", "--json"});
  EXPECT_EQ(nlohmann::json::parse(json.out)["findings"],
            nlohmann::json::parse(document)["findings"]);
}

}  // namespace
}  // namespace conddp
