#include <cmath>

#include "base/files/check_sums.hpp"
#include "problem_text.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

std::string with_guess(const std::string& guess) {
  return std::string(kPendulum) + "initial_guess: " + guess + "\n";
}

TEST(Guess, StaysAtTheInitialStateByDefault) {
  const Loaded loaded{std::string(kPendulum)};
  ASSERT_TRUE(loaded.built);
  for (int k = 0; k <= 10; ++k) EXPECT_EQ(loaded.built->guess.x(k)[0], 0.1);
  EXPECT_EQ(loaded.built->guess.u(0)[0], 0);
  EXPECT_EQ(loaded.built->guess_used.controls, "zero");
}

TEST(Guess, InterpolatesToTheTarget) {
  const Loaded loaded(with_guess("{states: interpolate}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(loaded.built->guess.x(4)[0], 0.1 + 0.9 * 0.4 / 0.7, 1e-12);
  EXPECT_NEAR(loaded.built->guess.x(10)[0], 1, 1e-12);
}

TEST(Guess, PassesThroughKeyframes) {
  const Loaded loaded(
      with_guess("{states: {keyframes: [{knot: 4, state: {values: {theta: 2}}}, {time: 0.7, state: "
                 "[3, 1]}]}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->guess.x(0)[0], 0.1);
  EXPECT_NEAR(loaded.built->guess.x(2)[0], 1.05, 1e-12);
  EXPECT_NEAR(loaded.built->guess.x(4)[0], 2, 1e-12);
  EXPECT_NEAR(loaded.built->guess.x(10)[1], 1, 1e-12);
}

TEST(Guess, PassesThroughKeyframesByASpline) {
  const std::string keyframes =
      "keyframes: [{knot: 4, state: [2, 0]}, {knot: 7, state: [3, 1]}, {knot: 10, state: [0, 0]}]";
  const Loaded straight(with_guess("{states: {" + keyframes + "}}"));
  const Loaded bent(with_guess("{states: {" + keyframes + ", interpolation: cubic}}"));
  ASSERT_TRUE(straight.built && bent.built) << straight.all() << bent.all();
  for (const int knot : {0, 4, 7, 10})
    EXPECT_NEAR(bent.built->guess.x(knot)[0], straight.built->guess.x(knot)[0], 1e-12);
  EXPECT_GT(bent.built->guess.x(6)[0], straight.built->guess.x(6)[0] + 0.05);
  EXPECT_NE(bent.built->guess_used.states.find("cubic spline"), std::string::npos);
}

TEST(Guess, ConstantAndRandomControls) {
  const Loaded a(with_guess("{controls: {constant: 2, random: {seed: 7, scale: 0.5}}}"));
  const Loaded b(with_guess("{controls: {constant: {torque: 2}, random: {seed: 7, scale: 0.5}}}"));
  const Loaded c(with_guess("{controls: {random: {seed: 8, scale: 0.5}}}"));
  ASSERT_TRUE(a.built && b.built && c.built) << a.all() << b.all() << c.all();
  EXPECT_EQ(a.built->guess.u(3)[0], b.built->guess.u(3)[0]);
  EXPECT_NE(a.built->guess.u(3)[0], 2 + c.built->guess.u(3)[0]);
  EXPECT_EQ(a.built->guess_used.seed, 7u);
  double mean = 0;
  for (int k = 0; k < 10; ++k) mean += a.built->guess.u(k)[0] / 10;
  EXPECT_NEAR(mean, 2, 1);
}

TEST(Guess, QuasiStaticControlsHoldTheStates) {
  const Loaded pendulum(with_guess("{controls: gravity}"));
  ASSERT_TRUE(pendulum.built) << pendulum.all();
  EXPECT_NEAR(pendulum.built->guess.u(0)[0], 9.81 * 0.5 * std::sin(0.1), 1e-12);
  // The hinge of the double pendulum carries both rods; compare with the system's acceleration.
  const Loaded robot(R"(conddp: 1
robot: {urdf: robots/double_pendulum.urdf}
initial_state: {joints: {shoulder: 0.4, elbow: -1}}
phases: [{knots: 2, dt: 0.1}]
initial_guess: {controls: quasi_static}
)");
  ASSERT_TRUE(robot.built) << robot.all();
  const System& system = *robot.built->plant.system;
  const auto data = system.create_data(double{});
  const Eigen::VectorXd u = robot.built->guess.u(0);
  system.evaluate(robot.built->problem->initial_state().data(), u.data(), *data);
  EXPECT_NEAR(data->f[0], 0, 1e-10);
  EXPECT_NEAR(data->f[1], 0, 1e-10);
}

class GuessFromFile : public testing::Test {
 protected:
  std::string write(const std::string& name, const std::string& text) {
    return folder_.write(name, text);
  }
  const TemporaryFolder folder_;
};

TEST_F(GuessFromFile, ReadsCsvByColumnNames) {
  const std::string file = write("a.csv",
                                 "torque [Nm],t [s],phase,omega,theta [rad]\n"
                                 "1,0,a,0,0\n2,0.2,b,0,4\n,0.7,b,1,4\n");
  const Loaded loaded(with_guess("{file: " + file + "}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Trajectory& guess = loaded.built->guess;
  EXPECT_EQ(guess.x(0)[0], 0.1);  // the initial state is kept
  EXPECT_NEAR(guess.x(1)[0], 2, 1e-12);
  EXPECT_NEAR(guess.x(10)[1], 1, 1e-12);
  EXPECT_EQ(guess.u(1)[0], 1);  // held
  EXPECT_EQ(guess.u(2)[0], 2);
  EXPECT_EQ(guess.u(9)[0], 2);
}

TEST_F(GuessFromFile, TakesSomeStatesByTheirNames) {
  const std::string file = write("a.csv", "t,omega,theta\n0,1,7\n1,1,7\n");
  const Loaded loaded(with_guess("{states: {file: " + file + ", columns: [omega]}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->guess.x(3), Eigen::Vector2d(0.1, 1)) << "theta is the initial one";
  const Loaded unknown(with_guess("{states: {file: " + file + ", columns: [w]}}"));
  EXPECT_FALSE(unknown.built);
  EXPECT_NE(unknown.all().find("by their names: theta, omega"), std::string::npos) << unknown.all();
}

TEST_F(GuessFromFile, ReadsAnEarlierSolution) {
  const std::string file = write("s.json", R"({"format": "conddp.solution/1", "gains": [[[1]]],
    "trajectory": {"columns": {"x": ["theta", "omega"], "u": ["torque"]},
                   "t": [0, 0.35, 0.7], "x": [[0, 0], [1, 0], [2, 0]], "u": [[3], [4]]}})");
  const Loaded loaded(with_guess("{file: " + file + "}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(loaded.built->guess.x(10)[0], 2, 1e-12);
  EXPECT_EQ(loaded.built->guess.u(9)[0], 4);
  EXPECT_NE(loaded.built->guess_used.states.find("s.json"), std::string::npos);
}

/// Halfway at 0.4 s, after the knots of the first phase.
const std::string kJumpOfOmega = "  - {jump: {omega: -0.5*omega}}\n  - {name: second";

TEST_F(GuessFromFile, KeepsTheStatesBeforeAndAfterAJump) {
  const std::string json = write("s.json", R"({"format": "conddp.solution/1", "gains": [[[1]]],
    "trajectory": {"columns": {"x": ["theta", "omega"], "u": ["torque"]},
                   "t": [0, 0.4, 0.4, 0.7], "x": [[0.1, 0], [1, 8], [1, -4], [2, -4]],
                   "u": [[3], [], [2]]}})");
  const std::string csv = write(
      "a.csv", fmt::format("t,theta,omega,torque\n0,0.1,0,3\n0.4,1,8,\n{},1,-4,2\n0.7,2,-4,\n",
                           std::nextafter(0.4, 1)));
  for (const std::string& file : {json, csv}) {
    const Loaded loaded(
        replaced(with_guess("{file: " + file + "}"), "  - {name: second", kJumpOfOmega));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const Trajectory& guess = loaded.built->guess;
    EXPECT_NEAR(guess.x(3)[1], 6, 1e-12) << file;
    EXPECT_EQ(guess.x(4)[1], 8) << file;
    EXPECT_EQ(guess.x(5)[1], -4) << file;
    EXPECT_NEAR(guess.x(6)[1], -4, 1e-12) << file;
    EXPECT_EQ(guess.u(3)[0], 3) << file;
    EXPECT_EQ(guess.u(5)[0], 2) << file;
  }
}

/// Slopes of collocation belong to its steps: they are recomputed or unused.
TEST_F(GuessFromFile, TakesOnlyActuatorsFromSolutionsWithSlopes) {
  const std::string file = write("s.json", R"({"format": "conddp.solution/1", "gains": [[[1]]],
    "trajectory": {"columns": {"x": ["theta", "omega"], "u": ["torque", "slope_end/omega"]},
                   "t": [0, 0.7], "x": [[0.1, 0], [2, 0]], "u": [[3, 99]]}})");
  for (const char* integrator : {"rk4", "trapezoidal", "hermite_simpson"}) {
    const Loaded loaded(replaced(with_guess("{file: " + file + "}"), "integrator: rk4",
                                 std::string("integrator: ") + integrator));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const Trajectory& guess = loaded.built->guess;
    const System& system = loaded.built->plant.actuated();
    const auto data = system.create_data(double{});
    for (int k = 0; k < guess.knots(); ++k) {
      EXPECT_EQ(guess.u(k)[0], 3) << integrator;
      system.evaluate(guess.x(k + 1).data(), guess.u(k).data(), *data);
      const double slope = guess.nu(k) > 1 ? guess.u(k)[guess.nu(k) - 1] : data->f[0];
      EXPECT_NEAR(slope, data->f[0], 1e-12) << integrator << " " << k;
    }
  }
}

TEST_F(GuessFromFile, IntegralsFollowFromOtherStates) {
  const std::string file = write("s.json", R"({"format": "conddp.solution/1",
    "trajectory": {"columns": {"x": ["theta", "omega", "work"], "u": ["torque"]},
                   "t": [0, 0.7], "x": [[0.1, 0, 0], [2, 1, 9]], "u": [[3]]}})");
  const std::string text = with_guess("{file: " + file + "}");
  const Loaded loaded(text + "integrals: {work: torque^2}\n");
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(loaded.built->guess.x(10)[0], 2, 1e-12);
  EXPECT_FALSE(Loaded(text).built) << "a state that the problem has not";
}

TEST_F(GuessFromFile, PhasesOfASolutionFitItsNodes) {
  for (const char* phases :
       {"3", R"([{"name": "a", "knots": 2}])", R"([{"name": "a", "knots": 0}])",
        R"([{"name": 1, "knots": 1}])", R"([{"name": "a", "knots": -1}])"}) {
    const std::string file =
        write("s.json", std::string(R"({"format": "conddp.solution/1", "trajectory": {"columns":
          {"x": ["theta", "omega"], "u": ["torque"]}, "t": [0, 0.7], "x": [[0, 0], [1, 0]],
          "u": [[3]], "phases": )") +
                            phases + "}}");
    const Loaded loaded(with_guess("{file: " + file + "}"));
    EXPECT_FALSE(loaded.built) << phases;
    EXPECT_NE(loaded.first_error().find("the solution cannot be used"), std::string::npos)
        << loaded.all();
  }
}

TEST_F(GuessFromFile, GainsMayBeNumerous) {
  std::string text = R"({"format": "conddp.solution/1", "gains": [0)";
  for (int i = 0; i < 5'500'000; ++i) text += ",0";
  text += R"(], "trajectory": {"columns": {"x": ["theta", "omega"], "u": ["torque"]},
      "t": [0, 0.7], "x": [[1, 1], [1, 1]], "u": [[0]]}})";
  const Loaded loaded(with_guess("{file: " + write("s.json", text) + "}"));
  EXPECT_TRUE(loaded.built) << loaded.first_error();
}

TEST_F(GuessFromFile, NamesMissingAndExtraColumns) {
  const std::string file = write(
      "s.json", R"({"format": "conddp.solution/1", "trajectory": {"columns": {"x": ["q/a", "theta"],
      "u": ["torque"]}, "t": [0, 0.7], "x": [[1, 1], [1, 1]], "u": [[0]]}})");
  const Loaded loaded(with_guess("{file: " + file + "}"));
  ASSERT_FALSE(loaded.built);
  EXPECT_NE(loaded.first_error().find("it lacks omega, and it has q/a"), std::string::npos)
      << loaded.all();
  const Loaded chosen(with_guess("{states: {file: " + file + ", columns: [theta, q/a]}}"));
  EXPECT_TRUE(chosen.built) << chosen.all();
}

TEST_F(GuessFromFile, WarnsOnceAboutAnotherDuration) {
  const auto text = [](double end) {
    return R"({"format": "conddp.solution/1", "trajectory": {"columns": {"x": ["theta", "omega"],
      "u": ["torque"]}, "t": [0, )" +
           std::to_string(end) + R"(], "x": [[1, 1], [1, 1]], "u": [[0]]}})";
  };
  for (const auto& [end, words] : {std::pair(0.5, "lasts 0.5 s, the problem 0.7 s"),
                                   std::pair(1.0, "lasts 1 s, the problem 0.7 s")}) {
    const Loaded loaded(with_guess("{file: " + write("s.json", text(end)) + "}"));
    ASSERT_TRUE(loaded.built) << loaded.all();
    ASSERT_EQ(loaded.diagnostics.list().size(), 1u) << loaded.all();
    EXPECT_EQ(loaded.diagnostics.list()[0].severity, Severity::kWarning);
    EXPECT_NE(loaded.all().find(words), std::string::npos) << loaded.all();
  }
  const Loaded same(with_guess("{file: " + write("s.json", text(0.7)) + "}"));
  EXPECT_TRUE(same.built);
  EXPECT_EQ(same.all(), "");
}

TEST_F(GuessFromFile, RemembersTheBytesRead) {
  const std::string text = "t,theta,omega,torque\n0,0,0,5\n0.7,7,1,6\n";
  const Loaded loaded(with_guess("{file: " + write("r.csv", text) + "}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  ASSERT_EQ(loaded.built->data_files.size(), 1u);
  EXPECT_EQ(loaded.built->data_files[0].file, (folder_ / "r.csv").string());
  EXPECT_EQ(loaded.built->data_files[0].sha256, sha256(text));
}

struct BadTable {
  const char* name;
  const char* file;
  const char* text;
  const char* error;
};

TEST_F(GuessFromFile, NamesErrors) {
  const std::string deep = "{\"trajectory\": " + std::string(100'000, '[');
  std::string large = "{\"trajectory\": [0";
  for (int i = 0; i < 5'000'000; ++i) large += ",0";
  const BadTable cases[] = {
      {"LargeJson", "s.json", large.c_str(),
       "0:0: the solution cannot be used: it has more than 5000000 values"},
      {"Header", "a.csv", "0,1\n1,2\n", "1:1: the first line must name the columns"},
      {"NoTime", "a.csv", "theta,omega\n1,2\n", "1:1: no column holds the time"},
      {"Twice", "a.csv", "t,theta,theta\n1,2,3\n", "1:9: two columns have the name 'theta'"},
      {"Cells", "a.csv", "t,theta\n1,2\n1,2,3\n", "3:1: this line has 3 cells, the header has 2"},
      {"Number", "a.csv", "t,theta\n0,x1\n", "2:3: in the column 'theta': 'x1' is not a number"},
      {"Order", "a.csv", "t,theta\n1,2\n1,3\n", "3:1: the time does not increase"},
      {"Empty", "a.csv", "t,theta\n", "1:1: there is no row under the header"},
      {"Missing", "a.csv", "t,theta,torque\n0,1,1\n", "17:23: "},
      {"Json", "s.json", "{\"format\": ", "1:12: not valid JSON"},
      {"OtherJson", "s.json", "{\"format\": 1}", "0:0: the solution cannot be used"},
      {"NoTrajectory", "s.json", "{\"format\": \"conddp.solution/1\"}",
       "0:0: the solution cannot be used: 'trajectory' is missing"},
      {"Truncated", "s.json", "{\"format\": \"conddp.solution/1\",\n \"trajectory\": {\"t\": [0, 1",
       "2:27: not valid JSON"},
      {"NotANumber", "s.json", "{\"trajectory\": {\"t\": [NaN]}}", "1:23: not valid JSON"},
      {"Huge", "s.json", "{\"trajectory\":\n {\"t\": [0, 1e999]}}",
       "2:12: a number of the solution is out of range"},
      {"Scalar", "s.json", "3", "0:0: the solution cannot be used: 'format' is missing"},
      {"Nothing", "s.json", "", "1:1: not valid JSON"},
      {"Names", "s.json",
       R"({"format": "conddp.solution/1", "trajectory": {"columns": {"x": ["a", "a"], "u": []}}})",
       "0:0: the solution cannot be used: 'a' stands twice in trajectory.columns.x"},
      {"Lengths", "s.json",
       R"({"format": "conddp.solution/1", "trajectory": {"columns": {"x": ["a"], "u": []},
           "t": [0, 1], "x": [[1], [1, 2]], "u": [[]]}})",
       "0:0: the solution cannot be used: trajectory.x[1] should have 1 numbers"},
      {"Words", "s.json",
       R"({"format": "conddp.solution/1", "trajectory": {"columns": {"x": ["a"], "u": []},
           "t": [0, 1], "x": [[1], ["b"]], "u": [[]]}})",
       "0:0: the solution cannot be used: trajectory.x[1] has an entry that is not a finite "
       "number"},
      {"OtherStates", "s.json",
       R"({"format": "conddp.solution/1", "trajectory": {"columns": {"x": ["q/a", "theta"],
           "u": ["torque"]}, "t": [0, 0.7], "x": [[1, 1], [1, 1]], "u": [[0]]}})",
       "17:23: the states of '"},
      {"OtherControls", "s.json",
       R"({"format": "conddp.solution/1", "trajectory": {"columns": {"x": ["theta", "omega"],
           "u": ["torque", "u/b"]}, "t": [0, 0.7], "x": [[1, 1], [1, 1]], "u": [[0, 0]]}})",
       "17:23: the controls of '"},
      {"DeepJson", "s.json", deep.c_str(),
       "0:0: the solution cannot be used: it is nested too deeply"},
  };
  for (const BadTable& c : cases) {
    const Loaded loaded(with_guess("{file: " + write(c.file, c.text) + "}"));
    EXPECT_FALSE(loaded.built) << c.name;
    EXPECT_EQ(loaded.first_error().substr(0, std::string_view(c.error).size()), c.error) << c.name;
  }
}

TEST_F(GuessFromFile, ReferencesComeFromFilesToo) {
  const std::string file = write("r.csv", "t,theta,omega,angle\n0,0,0,5\n0.7,7,1,6\n");
  const Loaded loaded(replaced(kPendulum, "costs:\n",
                               "costs:\n  track: {residual: state, reference: {file: " + file +
                                   "}}\n  one: {residual: state, "
                                   "columns: theta, reference: {file: " +
                                   file + ", columns: [angle]}}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const KnotModel& model = *loaded.built->problem->knot(0).model;
  const double* p = loaded.built->problem->knot(2).parameters;
  EXPECT_NEAR(p[model.costs()[0].parameters], 2, 1e-12);
  EXPECT_NEAR(p[model.costs()[1].parameters], 5 + 2.0 / 7, 1e-12);
}

/// Includes a chosen initial state, used by a cycle, after the velocities.
TEST(Guess, AccelerationsOfFoundContactsFollowGuessedStates) {
  for (const bool chosen : {false, true}) {
    const Loaded loaded(
        "conddp: 1\n"
        "robot: {urdf: robots/acrobot.urdf, actuation: {joints: [elbow]}}\n"
        "initial_state: {}\n"
        "stepping: {joint_limits: {elbow: [-1.5, 1.5]}}\n"
        "phases:\n" +
        std::string(chosen ? "  - {choose: [q/elbow, v/elbow]}\n" : "") +
        "  - {knots: 2, dt: 0.1}\n"
        "costs:\n  effort: {residual: control}\n" +
        (chosen ? "terminal: {constraints: {cycle: {residual: cycle}}}\n" : "") +
        "initial_guess: {states: {keyframes: [{time: 0, state: {}}, "
        "{time: 0.2, state: {velocity: {joints: {shoulder: 2, elbow: -4}}}}]}}\n"
        "solver: {name: ipopt}\n");
    ASSERT_TRUE(loaded.built) << loaded.all();
    for (int k = 0; k < 2; ++k) {
      const auto u = loaded.built->guess.u(k + (chosen ? 1 : 0));
      EXPECT_NEAR(u[1], 10, 1e-12) << chosen << k;
      EXPECT_NEAR(u[2], -20, 1e-12) << chosen << k;
    }
  }
}

TEST(GuessToEqualities, LeadsToTheConstrainedTerminalState) {
  const std::string text = R"(conddp: 1
system: {states: [x, v], controls: [u], rate: {x: v, v: u}}
initial_state: {values: {x: 1}}
phases: [{name: only, knots: 4, duration: 1}]
costs: {u: {residual: control}}
terminal: {constraints: {end: CONSTRAINT}}
initial_guess: {states: interpolate}
)";
  const std::pair<const char*, std::vector<double>> cases[] = {
      {"{residual: state, reference: [3, 2]}", {3, 2}},
      {"{residual: state, columns: v, reference: 4}", {1, 4}},
      {"{residual: state, equals: {x: 5}}", {5, 0}},
      {"{residual: state, columns: x, reference: 1, equals: 2}", {3, 0}}};
  for (const auto& [constraint, end] : cases) {
    const Loaded loaded(replaced(text, "CONSTRAINT", constraint));
    ASSERT_TRUE(loaded.built) << loaded.all();
    for (int i = 0; i < 2; ++i) {
      const double begin = i == 0 ? 1 : 0;
      EXPECT_DOUBLE_EQ(loaded.built->guess.x(4)[i], end[i]) << constraint;
      EXPECT_DOUBLE_EQ(loaded.built->guess.x(2)[i], 0.5 * (begin + end[i])) << constraint;
    }
  }
  const Loaded bounded(replaced(text, "CONSTRAINT", "{residual: state, lower: 1}"));
  EXPECT_NE(bounded.first_error().find("needs a terminal cost or equality"), std::string::npos)
      << bounded.all();
}

}  // namespace
}  // namespace conddp
