// Phases whose systems have different states or controls.
#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// From x = 1 with v = 0.33 to 0: 1 s by acceleration, then 1 s by velocity. An acceleration in
/// knot k moves the end by c dt with c = 0.9, 0.7, …, 0.1, and a velocity by dt. The constraint is
/// 1.33 + Σ c a dt + Σ w dt = 0 with minimum ½ Σ (a² + w²) dt. Since Σ c² dt + Σ dt = 0.33 + 1, the
/// optimum is a = −c and w = −1.
constexpr std::string_view kHandover = R"(conddp: 1
name: handover
systems:
  free: {states: {x: m, v: m/s}, controls: {a: m/s^2}, rate: {x: v, v: a}}
  carried: {states: {x: m}, controls: {w: m/s}, rate: {x: w}}
initial_state: {values: {x: 1, v: 0.33}}
phases:
  - {name: flight, system: free, knots: 5, duration: 1}
  - {name: carried, system: carried, knots: 4, duration: 1}
costs:
  effort: {residual: control}
terminal:
  constraints:
    home: {residual: state}
solver: {name: altro, tolerances: {stationarity: 1.0e-10, constraint: 1.0e-11}}
)";

/// From x = 1.72 to 0: 1 s by velocity, then 1 s by acceleration, starting with a velocity of half
/// the position: 1.5 (1.72 + Σ u dt) + Σ c a dt = 0. With Σ 1.5² dt + Σ c² dt = 2.25 + 0.33, the
/// optimum is u = −1.5 and a = −c.
constexpr std::string_view kLeap = R"(conddp: 1
name: leap
parameters: {gain: 0.5}
systems:
  slide: {states: {x: m}, controls: {u: m/s}, rate: {x: u}}
  fly: {states: {v: m/s, x: m}, controls: {a: m/s^2}, rate: {x: v, v: a}}
initial_state: {values: {x: 1.72}}
phases:
  - {name: slide, system: slide, knots: 5, duration: 1}
  - {name: leap, jump: {v: gain*x}}
  - {name: fly, system: fly, knots: 5, duration: 1}
costs:
  effort: {residual: control}
terminal:
  constraints:
    home: {residual: state, columns: x}
solver: {name: altro, tolerances: {stationarity: 1.0e-10, constraint: 1.0e-11}}
)";

constexpr double kLevers[] = {0.9, 0.7, 0.5, 0.3, 0.1};

SolveResult answer_of(const Loaded& loaded, std::string_view solver) {
  return solve(*loaded.built->problem, std::string(solver), loaded.spec->solver.options,
               loaded.built->guess);
}

std::vector<std::string> names_of(const std::vector<Column>& columns) {
  std::vector<std::string> names;
  for (const Column& column : columns) names.push_back(column.name);
  return names;
}

using Names = std::vector<std::string>;

TEST(DifferentStates, StatesAbsentLaterRestAndCostNothing) {
  const Loaded loaded{std::string(kHandover)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(names_of(loaded.built->state_columns), (Names{"x", "v"}));
  EXPECT_EQ(names_of(loaded.built->control_columns), (Names{"a", "w"}));
  for (const char* solver : {"altro", "proxddp", "intro", "ipopt"}) {
    const SolveResult result = answer_of(loaded, solver);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_NEAR(result.cost, 0.665, 1e-9) << solver;
    const Trajectory& answer = result.trajectory;
    for (int k = 0; k < 5; ++k) EXPECT_NEAR(answer.u(k)[0], -kLevers[k], 1e-8) << solver << k;
    for (int k = 5; k < 9; ++k) EXPECT_NEAR(answer.u(k)[0], -1, 1e-8) << solver << k;
    EXPECT_NEAR(answer.x(5)[0], 1, 1e-8) << solver;
    EXPECT_NEAR(answer.x(5)[1], -0.17, 1e-8) << solver;
    EXPECT_NEAR(answer.x(9)[1], answer.x(5)[1], 1e-11) << solver;
  }
}

/// ẋ = w with the cost ½ (x² + w²) dt: p² = 1 + p dt.
TEST(DifferentStates, RegulatorsHoldStatesOfTheLastPhase) {
  const Loaded loaded(replaced(
      replaced(kHandover, "  constraints:\n    home: {residual: state}", "  lqr: {values: {x: 0}}"),
      "costs:\n", "costs:\n  near: {residual: state, columns: [x]}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Eigen::MatrixXd& P = loaded.built->terminal_lqr->ingredients.P;
  const double dt = 0.25;
  EXPECT_NEAR(P(0, 0), 0.5 * (dt + std::sqrt(dt * dt + 4)), 1e-12);
  EXPECT_NEAR(P.norm(), P(0, 0), 1e-12) << "the velocity rests";
}

TEST(DifferentStates, JumpGivesAStateItsFirstValue) {
  const Loaded loaded{std::string(kLeap)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(names_of(loaded.built->state_columns), (Names{"x", "v"}));
  for (const char* solver : {"altro", "proxddp", "intro", "ipopt"}) {
    const SolveResult result = answer_of(loaded, solver);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_NEAR(result.cost, 1.29, 1e-9) << solver;
    const Trajectory& answer = result.trajectory;
    EXPECT_NEAR(answer.u(0)[0], -1.5, 1e-8) << solver;
    for (int k = 6; k < 11; ++k) EXPECT_NEAR(answer.u(k)[0], -kLevers[k - 6], 1e-8) << solver << k;
    EXPECT_NEAR(answer.x(5)[0], 0.22, 1e-8) << solver;
    EXPECT_NEAR(answer.x(5)[1], 0, 1e-11) << solver << ": before it begins";
    EXPECT_NEAR(answer.x(6)[1], 0.11, 1e-8) << solver;
  }
}

/// Collocation rules are exact on these motions too.
TEST(DifferentStates, AreCollocatedToTheSameOptimum) {
  for (const char* rule : {"trapezoidal", "hermite_simpson", "radau3", "radau5"})
    for (const std::string_view text : {kHandover, kLeap}) {
      SCOPED_TRACE(rule);
      const Loaded loaded(
          replaced(text, "initial_state", std::string("integrator: ") + rule + "\ninitial_state"));
      ASSERT_TRUE(loaded.built) << loaded.all();
      for (const DerivativeComparison& c :
           check_derivatives(*loaded.built->problem, loaded.built->guess))
        EXPECT_LE(c.error, kDerivativeTolerance) << c.knot << " " << c.row << " " << c.column;
      for (const char* solver : {"altro", "proxddp", "intro", "ipopt"}) {
        const SolveResult result = answer_of(loaded, solver);
        ASSERT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
        EXPECT_NEAR(result.cost, text == kLeap ? 1.29 : 0.665, 1e-8) << solver;
        const int first = text == kLeap ? 6 : 0;  // of the acceleration
        for (int k = 0; k < 5; ++k)
          EXPECT_NEAR(result.trajectory.u(first + k)[0], -kLevers[k], 1e-6) << solver << k;
      }
    }
}

/// Slopes of resting states are controls too, so all phases have the same slope columns. Guesses
/// cover the actuators, and slopes follow.
TEST(DifferentStates, HaveSlopesAfterControlsOfTheirPhases) {
  const Loaded loaded(replaced(kHandover, "initial_state",
                               "integrator: trapezoidal\ninitial_guess: {controls: {constant: {a: "
                               "2, w: 3}}}\ninitial_state"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(names_of(loaded.built->control_columns),
            (Names{"a", "slope_end/x", "slope_end/v", "w"}));
  const Trajectory& guess = loaded.built->guess;
  for (int k = 0; k < 5; ++k) EXPECT_EQ(guess.u(k), Eigen::Vector3d(2, 0.33, 2));
  for (int k = 5; k < 9; ++k) EXPECT_EQ(guess.u(k), Eigen::Vector3d(3, 3, 0));
}

TEST(DifferentStates, StateWithoutJumpBeginsAtItsInitialValue) {
  std::string text = replaced(kLeap, "  - {name: leap, jump: {v: gain*x}}\n", "");
  text = replaced(text, "{x: 1.72}", "{x: 1.22, v: 0.11}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = answer_of(loaded, "altro");
  // 1.22 + 0.11 + Σ u dt + Σ c a dt = 0.
  EXPECT_NEAR(result.cost, 0.665, 1e-9) << result.message;
  EXPECT_NEAR(result.trajectory.x(5)[1], 0.11, 1e-11);
}

TEST(DifferentStates, DifferenceEquationsSupportThemToo) {
  std::string text = replaced(kLeap, "rate: {x: u}", "next: {x: x + 0.2*u}");
  text = replaced(text, "rate: {x: v, v: a}", "next: {x: x + 0.2*v + 0.02*a, v: v + 0.2*a}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = answer_of(loaded, "altro");
  EXPECT_NEAR(result.cost, 1.29, 1e-9) << result.message;
}

TEST(DifferentStates, AllSolversFindTheOptimum) {
  const std::string text = replaced(kHandover, "  constraints:\n    home: {residual: state}",
                                    "  costs:\n    home: {residual: state}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const SolverInfo& solver : solvers()) {
    if (unsupported(solver, *loaded.built->problem)) continue;
    const SolveResult result = answer_of(loaded, solver.name);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver.name << ": " << result.message;
    EXPECT_NEAR(result.cost, 0.5 * 1.33 * 1.33 / 2.33, 1e-9) << solver.name;
  }
}

TEST(DifferentStates, NamedBoundsApplyToPhasesWithTheControl) {
  const Loaded loaded(replaced(kHandover, "terminal:",
                               "constraints:\n  limit: {bounds: control, lower: {w: -0.5}}\n"
                               "terminal:"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const char* solver : {"altro", "ipopt"}) {
    const SolveResult result = answer_of(loaded, solver);
    // Remaining for the accelerations: 0.83 = λ Σ c² dt.
    EXPECT_NEAR(result.cost, 0.5 * 0.83 * 0.83 / 0.33 + 0.125, 1e-8) << solver << result.message;
    EXPECT_NEAR(result.trajectory.u(7)[0], -0.5, 1e-9) << solver;
  }
}

TEST(DifferentStates, UnnamedColumnsMeanThoseOfThePhase) {
  std::string text =
      replaced(kHandover, "terminal:", R"(  posture: {residual: state, weights: {v: 2}}
  shares: {residual: control, weights: {a: 2, w: 3}}
constraints:
  room: {bounds: state, lower: -10, upper: {v: 20}}
terminal:)");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& phases = loaded.built->problem->phases();
  const auto rows = [&](int phase, int cost) {
    return phases[phase].model->costs()[cost].residual->size();
  };
  EXPECT_EQ(rows(0, 1), 2);
  EXPECT_EQ(rows(1, 1), 1);
  EXPECT_EQ(phases[0].model->costs()[2].activation.weights, std::vector<double>{2});
  EXPECT_EQ(phases[1].model->costs()[2].activation.weights, std::vector<double>{3});
  ASSERT_EQ(phases[0].model->constraints().size(), 1u);
  EXPECT_EQ(phases[0].model->constraints()[0].rows, 2);
  ASSERT_EQ(phases[1].model->constraints().size(), 1u);
  EXPECT_EQ(phases[1].model->constraints()[0].rows, 1);
  EXPECT_EQ(loaded.built->problem->terminal().model->constraints().size(), 2u);
}

TEST(DifferentStates, StateBoundAppliesToPhasesWithTheState) {
  const Loaded loaded(replaced(
      kHandover, "terminal:", "constraints:\n  slow: {bounds: state, upper: {v: 1}}\nterminal:"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->phases()[0].model->constraints().size(), 1u);
  EXPECT_TRUE(loaded.built->problem->phases()[1].model->constraints().empty());
  EXPECT_EQ(loaded.built->problem->terminal().model->constraints().size(), 1u);
}

TEST(DifferentStates, ControlCostIsOffWithoutControls) {
  const Loaded loaded(
      replaced(kHandover, "controls: {w: m/s}, rate: {x: w}", "controls: {}, rate: {x: -1}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->nu(7), 0);
  const SolveResult result = answer_of(loaded, "altro");
  // 0.33 + Σ c a dt = 0.
  EXPECT_NEAR(result.cost, 0.5 * 0.33, 1e-9) << result.message;
}

TEST(DifferentStates, ChoiceAndPerturbationUseFirstSystemStates) {
  const std::string chosen =
      replaced(kLeap, "phases:\n", "phases:\n  - {choose: all, lower: -1, upper: 1}\n");
  const Loaded loaded(chosen);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->nu(0), 1);
  const Loaded named(replaced(chosen, "choose: all", "choose: [x, v]"));
  ASSERT_TRUE(named.built) << named.all();
  EXPECT_EQ(named.built->problem->nu(0), 2);
  const Loaded moved(std::string(kLeap) + "perturbation: {initial_state: 0.1}\n");
  ASSERT_TRUE(moved.built) << moved.all();
  EXPECT_NE(moved.built->problem->initial_state()[0], 1.72);
  EXPECT_EQ(moved.built->problem->initial_state()[1], 0);
}

TEST(DifferentStates, CycleLinksStatesPresentAtBothEnds) {
  for (const std::string_view text : {kHandover, kLeap}) {
    std::string periodic =
        replaced(text, "phases:\n", "phases:\n  - {choose: all, lower: -1, upper: 1}\n");
    const std::size_t home = periodic.find("home:");
    periodic.replace(home, periodic.find('\n', home) - home, "home: {residual: cycle}");
    const Loaded loaded(periodic);
    ASSERT_TRUE(loaded.built) << loaded.all();
    EXPECT_EQ(loaded.built->problem->terminal().model->constraints()[0].rows, 1);
  }
}

TEST(DifferentStates, TimeIsASharedStateWhenNeeded) {
  const Loaded loaded(replaced(kHandover, "rate: {x: w}", "rate: {x: w*t}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(names_of(loaded.built->state_columns), (Names{"x", "v", "t"}));
  const SolveResult result = answer_of(loaded, "altro");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.trajectory.x(5)[2], 1, 1e-12);
  EXPECT_NEAR(result.trajectory.x(9)[2], 2, 1e-12);
}

TEST(DifferentStates, SupportFreeDurationsAndParameters) {
  std::string text = replaced(kHandover, "name: handover\n",
                              "name: handover\n"
                              "parameters: {gain: {free: true, lower: 1, upper: 2, start: 1}}\n");
  text = replaced(text, "rate: {x: w}", "rate: {x: gain*w}");
  text = replaced(text, "phases:\n", "phases:\n  - {choose: none}\n");
  text = replaced(text, "  - {name: carried, system: carried, knots: 4, duration: 1}",
                  "  - {name: carried, system: carried, knots: 4, duration: 1, free_duration: "
                  "{lower: 1, upper: 2}}");
  text = replaced(text, "home: {residual: state}", "home: {residual: state, columns: x}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(names_of(loaded.built->plant.system->state_columns()), (Names{"x", "v", "gain"}));
  const SolveResult result = answer_of(loaded, "ipopt");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  // The largest factor and the longest time are optimal: 1.33²/2 / (0.33 + 2² · 2).
  EXPECT_NEAR(result.cost, 0.5 * 1.33 * 1.33 / 8.33, 1e-7);
}

TEST(DifferentStates, ConstantGuessNamesControlsOfAllPhases) {
  const Loaded loaded(std::string(kHandover) +
                      "initial_guess: {controls: {constant: {a: 2, w: 3}}}\n");
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->guess.u(4)[0], 2);
  EXPECT_EQ(loaded.built->guess.u(5)[0], 3);
}

TEST(DifferentStates, RotationsRestToo) {
  const Loaded loaded(R"(conddp: 1
systems:
  turn: {states: {att: unit_quaternion, s: 1}, controls: [wx, wy, wz], rate: {att: "[wx, wy, wz]", s: wx}}
  stand: {states: {s: 1}, controls: [u], rate: {s: u}}
initial_state: {values: {s: 1}}
phases:
  - {name: turn, system: turn, knots: 5, duration: 1}
  - {name: stand, system: stand, knots: 5, duration: 1}
costs:
  effort: {residual: control}
  state: {residual: state}
solver: {name: box_fddp}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& phases = loaded.built->problem->phases();
  EXPECT_EQ(phases[0].model->costs()[1].residual->size(), 4);
  EXPECT_EQ(phases[1].model->costs()[1].residual->size(), 1);
  const SolveResult result = answer_of(loaded, "box_fddp");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_TRUE(result.trajectory.x(10).head(4) == result.trajectory.x(5).head(4));
}

TEST(DifferentStates, ExpansionIsEquivalent) {
  for (const std::string_view text : {kHandover, kLeap}) {
    const Loaded loaded{std::string(text)};
    ASSERT_TRUE(loaded.built) << loaded.all();
    const OrderedJson expanded = expand_problem(*loaded.built);
    const Loaded again(expanded.dump());
    ASSERT_TRUE(again.built) << again.all() << expanded;
    EXPECT_EQ(expand_problem(*again.built), expanded);
    EXPECT_EQ(answer_of(again, "altro").cost, answer_of(loaded, "altro").cost);
  }
}

TEST(DifferentStates, ReportsMistakesAtTheirPlaces) {
  struct {
    std::string_view text, from, to, error;
  } const cases[] = {
      {kHandover, "home: {residual: state}", "home: {residual: state, columns: [x, v]}",
       "14:42: the system 'carried' has no state 'v'"},
      {kHandover, "terminal:", "  speed: {residual: expression, rows: [v]}\nterminal:",
       "12:40: unknown name 'v'"},
      {kHandover, "terminal:", "  sum: {residual: combination, rows: [{x: 1, v: 1}]}\nterminal:",
       "12:46: 'v' is not a column of the state or control that can be combined"},
      {kHandover, "carried: {states: {x: m}", "carried: {states: {x: cm}",
       "5:3: 'x' is in m in 'free' and in cm in 'carried'"},
      {kHandover, "w: m/s}, rate: {x: w}", "a: m/s}, rate: {x: a}",
       "5:3: 'a' is in m/s^2 in 'free' and in m/s in 'carried'"},
      {kHandover, "carried: {states: {x: m}, controls: {w: m/s}, rate: {x: w}}",
       "carried: {states: {x: unit_quaternion}, controls: {w: m/s}, rate: {x: '[w, 0, 0]'}}",
       "5:3: 'x' is a number in one system and a rotation or a pose in another"},
      {kHandover, "rate: {x: w}", "next: {x: w}",
       "5:3: 'carried' is of another kind than the first system"},
      {kHandover, "carried: {states: {x: m}, controls: {w: m/s}, rate: {x: w}}",
       "carried: {positions: {x: m}, velocities: {v: m/s}, controls: {w: m/s}, acceleration: {v: "
       "w}}",
       "5:3: 'carried' is of another kind than the first system"},
      {kHandover, "carried: {states: {x: m}, controls: {w: m/s}, rate: {x: w}}",
       "carried: {type: pendulum}",
       "5:3: the states of 'carried' are theta, omega, those of 'free' "
       "x, v"},
      {kHandover, "initial_state:", "controls: linear\ninitial_state:",
       "4:3: 'free' does not have the controls of all systems, and 'controls: linear' needs the "
       "same ones in all of them"},
      {kHandover, "terminal:", "  smooth: {residual: control_rate}\nterminal:",
       "4:3: 'free' does not have the controls of all systems, and 'control_rate' needs the same "
       "ones in all of them"},
      {kHandover, "terminal:", "  mine: {residual: control, weights: {b: 2}}\nterminal:",
       "12:39: 'b' fits none of the controls"},
      {kLeap, "gain*x", "gain*v", "10:33: unknown name 'v'"},
      {kLeap, "{v: gain*x}", "{w: gain*x}", "10:25: there is no state 'w' that could jump"},
  };
  for (const auto& c : cases) {
    const Loaded loaded(replaced(c.text, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_TRUE(loaded.first_error().starts_with(c.error)) << c.to << "\n" << loaded.all();
  }
}

}  // namespace
}  // namespace conddp
