#include <map>
#include <sstream>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "process.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

const std::string kArm = source("problems/arm_reach.yaml");

Json solution_of(const std::filesystem::path& folder) {
  return Json::parse(read_file(folder / "solution.json"));
}

TEST(Check, ReportsItsUnderstanding) {
  const ProcessResult r = run_conddp({"check", kArm});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err, "");
  for (const char* words :
       {"arm_reach: the problem is well formed", "fixed base, 7 degrees of freedom",
        "14 numbers (14 directions), 7 controls", "reach: 35 knots of 0.01 s, 0.35 s",
        "tool: frame_placement, 6 rows, quadratic, weight 10000",
        "torque: bounds on the control from the URDF, in reach", "enforces the control bounds"})
    EXPECT_NE(r.out.find(words), std::string::npos) << words << "\n" << r.out;
}

TEST(Check, DistinguishesBoundsFromNormsAndNamesSolverSupport) {
  const std::string file = source("problems/double_integrator_limits.yaml");
  const ProcessResult norm =
      run_conddp({"check", file, "--set", "constraints={push: {residual: control, at_most: 3}}"});
  EXPECT_EQ(norm.exit_code, 0) << norm.err;
  for (const char* words : {"push: bounds on the norm of control, in move\n",
                            "goal: constraint on state, at the last node\n",
                            ": enforces the constraints\n", "state: q/0, v/0; control: u/0\n"})
    EXPECT_NE(norm.out.find(words), std::string::npos) << words << "\n" << norm.out;
  const ProcessResult both = run_conddp({"check", file});
  EXPECT_NE(both.out.find("force: bounds on the control, in move\n"), std::string::npos)
      << both.out;
  EXPECT_NE(both.out.find(": enforces the control bounds and the constraints\n"),
            std::string::npos);
  const ProcessResult none = run_conddp({"check", kPendulum, "--set", "constraints={}"});
  EXPECT_NE(none.out.find(": nothing is constrained\n"), std::string::npos) << none.out;
}

TEST(Check, NamesSystemOfEachPhaseAcrossJumps) {
  const TemporaryFolder folder;
  const std::string file = folder.write("two.yaml", R"(conddp: 1
systems: {a: {type: pendulum}, b: {type: pendulum, damping: 0.5}}
initial_state: {values: {theta: 1}}
phases:
  - {name: turn, jump: {theta: -theta}}
  - {name: one, system: a, knots: 20, dt: 0.05}
  - {name: two, system: b, knots: 10, dt: 0.05}
costs: {u: {residual: control}}
)");
  const ProcessResult text = run_conddp({"check", file});
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const char* words :
       {"2 numbers (2 directions), 1 controls\n", "integrator      semi_implicit_euler\n",
        "turn: a jump of states\n", "one: 20 knots of 0.05 s, 1 s, system a\n",
        "two: 10 knots of 0.05 s, 0.5 s, system b\n"})
    EXPECT_NE(text.out.find(words), std::string::npos) << words << "\n" << text.out;
  const ProcessResult json = run_conddp({"check", file, "--json"});
  EXPECT_TRUE(fits_schema("check", json.out)) << json.out;
  const Json phases = Json::parse(json.out)["phases"];
  EXPECT_FALSE(phases[0].contains("system"));
  EXPECT_EQ(phases[1]["system"], "a");
  EXPECT_EQ(phases[2]["system"], "b");
}

TEST(Check, ListsContactsOfPhasesAndCandidates) {
  const ProcessResult scheduled = run_conddp({"check", source("problems/hopper_cycle.yaml")});
  for (const char* words :
       {"start: the first state is chosen\n", "push: 20 knots of 0.01 s, 0.2 s, in contact: foot\n",
        "flight: 25 knots of 0.01 s, 0.25 s\n", "touch_down: an impulse at foot\n"})
    EXPECT_NE(scheduled.out.find(words), std::string::npos) << words << "\n" << scheduled.out;
  const ProcessResult found = run_conddp({"check", source("problems/raibert_gait.yaml")});
  EXPECT_NE(
      found.out.find("  may touch       foot: a sphere of 0.05 m at foot against a half-space "
                     "of world, friction 0.5\n"),
      std::string::npos)
      << found.out;
}

TEST(Check, NamesRedundantContacts) {
  const std::string squat = source("problems/biped_squat.yaml");
  const ProcessResult whole = run_conddp({"check", squat});
  EXPECT_EQ(whole.out.find("redundant"), std::string::npos) << whole.out;
  // Legs without ankle roll: their reciprocal screws, forces along the line through the hips,
  // coincide for parallel legs.
  const ProcessResult stiff =
      run_conddp({"check", squat, "--set", "robot.locked_joints.l_ankle_roll=0", "--set",
                  "robot.locked_joints.r_ankle_roll=0"});
  EXPECT_NE(stiff.out.find("in contact: left, right (redundant: 11 of 12 rows are independent in "
                           "the initial state; forces between left, right are not determined)"),
            std::string::npos)
      << stiff.out << stiff.err;
}

TEST(Check, PrintsEquationsAndRowsAsFormulas) {
  const ProcessResult r =
      run_conddp({"check", source("problems/collection/robot_arm.yaml"), "--set",
                  "constraints.slow={residual: expression, rows: {power: "
                  "pull*v}, upper: 9}"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  for (const char* words : {"  system          expressions\n"
                            "                    I = ((L - rho)^3 + rho^3)/3\n"
                            "                    v' = pull/L\n",
                            "time: expression, 1 rows, linear, weight 1, in turn\n"
                            "                    1\n",
                            "slow: constraint on expression, in turn\n"
                            "                    power = pull*v\n"})
    EXPECT_NE(r.out.find(words), std::string::npos) << words << "\n" << r.out;
}

TEST(Check, JsonFitsItsSchema) {
  for (const std::string& file :
       {kArm, kPendulum, source("problems/hopper_cycle.yaml"), source("problems/push_box.yaml"),
        source("problems/collection/robot_arm.yaml")})
    for (const bool derivatives : {false, true}) {
      std::vector<std::string> arguments = {"check", file, "--json"};
      if (derivatives) arguments.push_back("--derivatives");
      const ProcessResult r = run_conddp(arguments);
      EXPECT_EQ(r.exit_code, 0) << r.err;
      EXPECT_TRUE(fits_schema("check", r.out)) << r.out;
      EXPECT_EQ(Json::parse(r.out).contains("derivatives"), derivatives);
    }
}

TEST(Check, TerminalPrintsTheRegulatorAndItsConditions) {
  const std::vector<std::string> arguments = {"check", kPendulum, "--terminal", "--set",
                                              "terminal.lqr=initial"};
  const ProcessResult text = run_conddp(arguments);
  EXPECT_EQ(text.exit_code, 0) << text.err;
  for (const char* words : {"lqr: state, 2 rows, quadratic, weight 1",
                            "|λ| of A − BK:", "A1 holds: ", "A2 holds: ", "A3 holds: ", "A4 "})
    EXPECT_NE(text.out.find(words), std::string::npos) << words << "\n" << text.out;
  std::vector<std::string> as_json = arguments;
  as_json.push_back("--json");
  const ProcessResult json = run_conddp(as_json);
  ASSERT_EQ(json.exit_code, 0) << json.err;
  EXPECT_TRUE(fits_schema("check", json.out)) << json.out;
  const Json lqr = Json::parse(json.out)["terminal_lqr"];
  EXPECT_EQ(lqr["columns"].size(), lqr["P"].size());
  EXPECT_EQ(lqr["conditions"]["checked"].size(), 4u);
  EXPECT_LT(lqr["eigenvalues"][0]["modulus"], 1);
}

TEST(Check, TerminalReportsEmptySamples) {
  const TemporaryFolder folder;
  const auto expect = [&](const char* text, const char* words, std::size_t conditions) {
    const std::string file = folder.write("problem.yaml", text);
    const ProcessResult plain = run_conddp({"check", file, "--terminal"});
    EXPECT_EQ(plain.exit_code, 0) << plain.err;
    EXPECT_NE(plain.out.find(words), std::string::npos) << plain.out;
    const ProcessResult json = run_conddp({"check", file, "--terminal", "--json"});
    EXPECT_TRUE(fits_schema("check", json.out)) << json.out;
    EXPECT_EQ(Json::parse(json.out)["terminal_lqr"]["conditions"]["checked"].size(), conditions);
  };
  expect(R"(conddp: 1
system: {states: [x], controls: [u], next: {x: 0.5*x}}
initial_state: {values: {x: 1}}
phases: [{knots: 20, dt: 1}]
costs: {u: {residual: control}}
terminal: {lqr: {values: {x: 0}}}
)",
         "P is zero: nothing to sample", 0);
  expect(R"(conddp: 1
system: {states: [x], controls: [u], next: {x: x + u}}
initial_state: {values: {x: 1}}
phases: [{knots: 20, dt: 1}]
costs: {u: {residual: control}, x: {residual: state}}
constraints: {b: {bounds: control, lower: 0, upper: 1}}
terminal: {lqr: {values: {x: 0}}}
)",
         "the set is the equilibrium alone: nothing to sample", 2);
}

TEST(Check, TerminalNamesSufficientWeightAtSmallerLevel) {
  const ProcessResult r =
      run_conddp({"check", kArm, "--terminal", "--set", "terminal.lqr=initial"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("no weight is enough at this level; "), std::string::npos) << r.out;
  EXPECT_NE(r.out.find(" times the weight is at level "), std::string::npos) << r.out;
}

TEST(Check, NamesSolverWithoutTerminalSetSupport) {
  const TemporaryFolder folder;
  const std::string file = folder.write("problem.yaml", R"(conddp: 1
system: {states: [x], controls: [u], next: {x: x + u}}
initial_state: {values: {x: 1}}
phases: [{knots: 20, dt: 1}]
costs: {u: {residual: control}, x: {residual: state}}
constraints: {b: {bounds: control, lower: -1, upper: 1}}
terminal: {lqr: {about: {values: {x: 0}}, set: true}}
)");
  const ProcessResult r = run_conddp({"check", file, "--solver", "box_fddp"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find(":7:48: error: box_fddp does not support"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("--set terminal.lqr.set=false"), std::string::npos) << r.err;
  EXPECT_EQ(run_conddp({"check", file, "--solver", "box_fddp", "--set", "terminal.lqr.set=false"})
                .exit_code,
            0);
}

TEST(Check, TerminalNeedsARegulator) {
  const ProcessResult r = run_conddp({"check", kPendulum, "--terminal"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("--terminal needs 'terminal: {lqr: STATE}', which the file does not have"),
            std::string::npos)
      << r.err;
  EXPECT_EQ(r.out, "");
}

TEST(Check, ListsThePhasesOfACost) {
  const ProcessResult r = run_conddp(
      {"check", source("problems/biped_steps.yaml"), "--json", "--set", "costs.cone.knots=[0]"});
  ASSERT_EQ(r.exit_code, 0) << r.err;
  std::map<std::string, Json> phases;
  const Json summary = Json::parse(r.out);
  for (const Json& cost : summary["costs"]) phases[cost["name"]] = cost["phases"];
  EXPECT_EQ(phases["effort"].size(), 7u);
  // By its knots, and by the node at the end of a swing.
  EXPECT_EQ(phases["cone"].size(), 1u);
  EXPECT_EQ(phases["swing_right"], (Json{"right_1", "double_2"}));
  const ProcessResult none =
      run_conddp({"check", source("problems/biped_steps.yaml"), "--set", "costs.effort.weight=0"});
  EXPECT_NE(none.out.find("effort: control, 0 rows, quadratic, weight 0, in no phase"),
            std::string::npos)
      << none.out;
}

TEST(Check, ShowsTheStepsOfRefinedPhases) {
  const ProcessResult r =
      run_conddp({"check", kArm, "--set", "phases.0.refine={first: 2, ratio: 0.5}"});
  EXPECT_NE(r.out.find("reach: 35 knots of 0.0025 to 0.01 s, 0.3375 s"), std::string::npos)
      << r.out << r.err;
}

TEST(Check, DerivativesNameRowsAndColumns) {
  const ProcessResult r = run_conddp({"check", kArm, "--derivatives", "--json"});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const Json derivatives = Json::parse(r.out)["derivatives"];
  EXPECT_TRUE(derivatives["holds"]);
  EXPECT_EQ(derivatives["tolerance"], 1e-6);
  // Dynamics, two residuals, and the gradient of the phase; the same without dynamics at the end.
  ASSERT_EQ(derivatives["compared"].size(), 7u);
  for (const Json& c : derivatives["compared"]) {
    EXPECT_NE(c["worst"]["row"], "");
    EXPECT_NE(c["worst"]["column"], "");
    EXPECT_LE(c["worst"]["relative_error"].get<double>(), 1e-6);
  }
  EXPECT_EQ(derivatives["compared"][0]["knots"], Json({0, 17, 34}));
  EXPECT_EQ(derivatives["compared"][0]["entries"], 2 * 3 * 14 * 21);
  const std::string column = derivatives["compared"][0]["worst"]["row"];
  EXPECT_TRUE(column.starts_with("q/joint_") || column.starts_with("v/joint_")) << column;
}

TEST(Check, ExpandedFileReachesTheSameCost) {
  const TemporaryFolder folder;
  const ProcessResult expanded = run_conddp({"check", kPendulum, "--expand"});
  EXPECT_EQ(expanded.exit_code, 0) << expanded.err;
  const std::string file = folder.write("expanded.yaml", expanded.out);
  EXPECT_EQ(run_conddp({"check", file, "--expand"}).out, expanded.out);
  const ProcessResult json = run_conddp({"check", kPendulum, "--expand", "--json"});
  EXPECT_TRUE(fits_schema("problem", json.out)) << json.out;
  run_conddp({"solve", kPendulum, "-o", folder.path() / "a", "--quiet"});
  run_conddp({"solve", file, "-o", folder.path() / "b", "--quiet"});
  const Json a = solution_of(folder.path() / "a"), b = solution_of(folder.path() / "b");
  EXPECT_EQ(a["cost"], b["cost"]);
  EXPECT_EQ(a["problem"]["configuration"], Json::parse(json.out));
  EXPECT_NE(a["problem"]["sha256"], b["problem"]["sha256"]);
}

TEST(Check, OverridesAreExpanded) {
  const ProcessResult r =
      run_conddp({"check", kPendulum, "--expand", "--json", "--set", "solver.max_iterations=7"});
  EXPECT_EQ(Json::parse(r.out)["solver"]["max_iterations"], 7);
}

TEST(Check, RejectionIsAnError) {
  const ProcessResult r = run_conddp({"check", kArm, "--solver", "ddp"});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_EQ(r.out, "");
  EXPECT_NE(r.err.find("ddp does not support the control bounds"), std::string::npos) << r.err;
  EXPECT_EQ(run_conddp({"check", kArm, "--solver", "ddp", "--drop", "torque"}).exit_code, 0);
  EXPECT_EQ(run_conddp({"check", kArm, "--set", "phases.0.dt=-1"}).exit_code, 2);
  EXPECT_EQ(run_conddp({"check", kArm, "--expand", "--derivatives"}).exit_code, 2);
}

class WarmStart : public testing::Test {
 protected:
  ProcessResult solve(const std::string& problem, const std::string& out,
                      std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"solve", problem, "-o", folder_.path() / out};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run_conddp(arguments);
  }
  Json solution(const std::string& name) { return solution_of(folder_.path() / name); }
  std::string file(const std::string& name) { return folder_.path() / name / "solution.json"; }
  TemporaryFolder folder_;
};

TEST_F(WarmStart, OwnSolutionNeedsNoFurtherWork) {
  for (const std::string& problem : {kArm, kPendulum, source("problems/body_reorient.yaml"),
                                     source("problems/quadrotor_waypoints.yaml")}) {
    EXPECT_EQ(solve(problem, "cold", {"--quiet"}).exit_code, 0);
    const ProcessResult r = solve(problem, "warm", {"--warm-start", file("cold")});
    EXPECT_EQ(r.exit_code, 0) << r.err;
    EXPECT_EQ(r.err, "");
    const Json cold = solution("cold"), warm = solution("warm");
    EXPECT_LE(warm["iterations"].get<int>(), 2) << problem;
    EXPECT_NEAR(warm["cost"], cold["cost"], 1e-6 * cold["cost"].get<double>()) << problem;
    EXPECT_EQ(warm["problem"]["data_files"][0]["file"], file("cold"));
    EXPECT_EQ(warm["problem"]["overrides"], Json({"initial_guess={file: " + file("cold") + "}"}));
    EXPECT_NE(warm["initial_guess_used"]["states"].get<std::string>().find(file("cold")),
              std::string::npos);
  }
}

/// "gap" of the first row of iterations.csv: distance of the guess from a motion.
double first_gap(const std::filesystem::path& folder) {
  std::istringstream lines(read_file(folder / "iterations.csv"));
  std::string header, row;
  std::getline(lines, header);
  std::getline(lines, row);
  std::istringstream names(header), cells(row);
  for (std::string name, cell; std::getline(names, name, ',') && std::getline(cells, cell, ',');)
    if (name == "gap" || name.starts_with("gap ")) return std::stod(cell);
  ADD_FAILURE() << "no gap in " << header;
  return 0;
}

TEST_F(WarmStart, KeepsTheStatesBeforeJumpsAndImpulses) {
  const std::string ball = folder_.write("ball.yaml", R"(conddp: 1
system: {states: {h: m, v: m/s}, controls: {u: N}, rate: {h: v, v: u - 9.81}}
initial_state: {values: {h: 5, v: 0}}
phases:
  - {name: down, knots: 20, duration: 1}
  - {name: bounce, jump: {v: -0.8*v}}
  - {name: again, knots: 20, duration: 1}
costs: {u: {residual: control}}
terminal: {costs: {g: {residual: state, reference: {values: {h: 3, v: 0}}, weight: 100}}}
)");
  for (const std::string& problem : {ball, source("problems/hopper_jump.yaml")}) {
    EXPECT_EQ(solve(problem, "cold", {"--quiet"}).exit_code, 0);
    for (const char* name : {"solution.json", "trajectory.csv"}) {
      const std::string former = folder_.path() / "cold" / name;
      const ProcessResult r = solve(problem, "warm", {"--warm-start", former});
      EXPECT_EQ(r.exit_code, 0) << r.err;
      EXPECT_LE(first_gap(folder_.path() / "warm"), 1e-9) << former;
      EXPECT_LE(solution("warm")["iterations"].get<int>(), 2) << former;
    }
  }
}

TEST_F(WarmStart, ServesAFinerGrid) {
  EXPECT_EQ(solve(kArm, "cold", {"--quiet"}).exit_code, 0);
  const std::vector<std::string> finer = {"--set", "phases.0.knots=70", "--set",
                                          "phases.0.dt=0.005"};
  std::vector<std::string> arguments = finer;
  arguments.insert(arguments.end(), {"--warm-start", file("cold")});
  const ProcessResult r = solve(kArm, "warm", arguments);
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.err, "");
  EXPECT_EQ(solve(kArm, "fine", finer).exit_code, 0);
  const Json warm = solution("warm"), fine = solution("fine");
  EXPECT_EQ(warm["trajectory"]["t"].size(), 71u);
  EXPECT_NEAR(warm["cost"], fine["cost"], 1e-6 * fine["cost"].get<double>());
  EXPECT_LE(warm["iterations"].get<int>(), fine["iterations"].get<int>());
}

TEST_F(WarmStart, AnotherDurationIsAWarning) {
  EXPECT_EQ(solve(kArm, "cold", {"--quiet"}).exit_code, 0);
  const ProcessResult r =
      solve(kArm, "warm", {"--set", "phases.0.knots=40", "--warm-start", file("cold")});
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.err.find("lasts 0.35 s, the problem 0.4 s"), std::string::npos) << r.err;
  EXPECT_EQ(r.err.find("lasts"), r.err.rfind("lasts")) << r.err;
}

TEST_F(WarmStart, RejectsAnotherRobotByName) {
  EXPECT_EQ(solve(kPendulum, "cold", {"--quiet"}).exit_code, 0);
  const ProcessResult r = solve(kArm, "warm", {"--warm-start", file("cold")});
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_NE(r.err.find("it lacks q/joint_1, q/joint_2"), std::string::npos) << r.err;
  EXPECT_NE(r.err.find("and it has "), std::string::npos) << r.err;
  EXPECT_FALSE(std::filesystem::exists(folder_.path() / "warm"));
}

TEST_F(WarmStart, RejectsFilesThatAreNotSolutions) {
  EXPECT_EQ(solve(kPendulum, "cold", {"--quiet"}).exit_code, 0);
  const std::string whole = read_file(file("cold"));
  const auto refused = [&](const std::string& path) {
    const ProcessResult r = solve(kPendulum, "warm", {"--warm-start", path});
    EXPECT_EQ(r.exit_code, 2) << path << r.err;
    EXPECT_FALSE(std::filesystem::exists(folder_.path() / "warm"));
    return r.err;
  };
  for (std::size_t i = 1; i < 10; ++i) {
    const std::string err =
        refused(folder_.write("cut.json", whole.substr(0, whole.size() * i / 10)));
    EXPECT_NE(err.find("cut.json:"), std::string::npos) << err;
    EXPECT_NE(err.find("not valid JSON"), std::string::npos) << err;
  }
  EXPECT_NE(refused(folder_.path() / "absent.json").find("does not exist"), std::string::npos);
  EXPECT_NE(refused(folder_.path()).find("is a folder"), std::string::npos);
  EXPECT_NE(refused("/dev/zero").find("not a regular file"), std::string::npos);
  EXPECT_NE(refused(kPendulum).find("pendulum_swingup.yaml:1:"), std::string::npos);
}

TEST_F(WarmStart, DivergedSolveExplainsItsNulls) {
  const std::string problem = folder_.write("explodes.yaml", R"(conddp: 1
system: {type: linear, A: [[1e200]], B: [[1]]}
initial_state: {state: [1]}
phases: [{knots: 20, dt: 0.1}]
costs: {x: {residual: state}, u: {residual: control}}
solver: {name: ilqr}
)");
  EXPECT_EQ(solve(problem, "out").exit_code, 1);
  const std::string text = read_file(file("out"));
  EXPECT_TRUE(fits_schema("solution", text));
  const Json s = Json::parse(text);
  EXPECT_EQ(s["status"], "diverged");
  EXPECT_TRUE(s["cost"].is_null());
  bool explained = false;
  for (const Json& entry : s["nulls"])
    explained |= entry["key"] == "cost" &&
                 entry["reason"].get<std::string>().find(s["message"].get<std::string>()) !=
                     std::string::npos;
  EXPECT_TRUE(explained) << s["nulls"];
  // It is not a valid starting point, and the tool says so.
  const ProcessResult r = solve(problem, "warm", {"--warm-start", file("out")});
  EXPECT_NE(r.exit_code, 0);
  EXPECT_LE(r.exit_code, 2) << r.err;
}

}  // namespace
}  // namespace conddp
