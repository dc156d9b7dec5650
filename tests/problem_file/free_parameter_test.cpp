// Free parameters of the problem.
#include <cmath>

#include "analysis/derivatives/derivative_check.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// ẋ = p + u from 0 to 1 in one second with cost ∫ u² dt + p²: p = u = 1/2 with cost 1/2. If p ≤
/// 1/4, u = 3/4 with cost 5/8.
constexpr std::string_view kDrift = R"(conddp: 1
parameters:
  c: 1
  p: {free: true, lower: -2, upper: 3, start: 0.1}
system: {states: [x], controls: [u], rate: {x: c*(p + u)}}
initial_state: {}
integrator: rk4
phases: [{choose: none}, {knots: 20, duration: 1}]
costs: {effort: {residual: expression, rows: [u], weight: 2}}
terminal:
  costs: {drift: {residual: expression, rows: [p], weight: 2}}
  constraints: {there: {residual: expression, rows: [x], equals: 1}}
solver: {name: altro}
)";

constexpr const char* kSolvers[] = {"altro", "proxddp", "ipopt"};

SolveResult answer_of(const Loaded& loaded, const char* solver) {
  return solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
}

int column_of(const Loaded& loaded, const std::string& name) {
  for (std::size_t i = 0; i < loaded.built->state_columns.size(); ++i)
    if (loaded.built->state_columns[i].name == name) return static_cast<int>(i);
  ADD_FAILURE() << "no column " << name;
  return 0;
}

TEST(FreeParameters, ReachTheirOptimumWithinAndAtBounds) {
  const Loaded inside{std::string(kDrift)}, bounded(replaced(kDrift, "upper: 3", "upper: 0.25"));
  ASSERT_TRUE(inside.built) << inside.all();
  ASSERT_TRUE(bounded.built) << bounded.all();
  for (const char* solver : kSolvers) {
    const SolveResult free = answer_of(inside, solver), bound = answer_of(bounded, solver);
    EXPECT_EQ(free.status, SolveStatus::converged) << solver;
    EXPECT_EQ(bound.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(free.cost, 0.5, 1e-6) << solver;
    EXPECT_NEAR(bound.cost, 0.625, 1e-6) << solver;
    const int p = column_of(inside, "p");
    for (int k = 1; k <= free.trajectory.knots(); ++k) {
      EXPECT_NEAR(free.trajectory.x(k)[p], 0.5, 1e-5) << solver;
      EXPECT_NEAR(bound.trajectory.x(k)[p], 0.25, 1e-6) << solver;
    }
  }
}

/// Moving a mass by 1 in 1 s from rest to rest costs ∫ u² dt + 1/m with u = m (6 − 12 t), that is
/// 12 m² + 1/m, so m = 24^(−1/3). Piecewise constant controls cost slightly more than 12.
TEST(FreeParameters, EquationMassHasMinimumCost) {
  const Loaded loaded(R"(conddp: 1
parameters: {mass: {free: true, lower: 0.1, upper: 2}}
system: {states: {x: m, v: m/s}, controls: {u: N}, rate: {x: v, v: u/mass}}
initial_state: {}
integrator: rk4
phases: [{choose: none}, {knots: 100, duration: 1}]
costs: {effort: {residual: control, weight: 2}}
terminal:
  costs: {light: {residual: expression, rows: [1/mass], activation: linear}}
  constraints: {there: {residual: state, columns: [x, v], equals: {x: 1, v: 0}}}
solver: {name: ipopt}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const double m = 1 / std::cbrt(24.0);
  for (const char* solver : {"ipopt", "altro"}) {
    const SolveResult result = answer_of(loaded, solver);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(result.cost, 12 * m * m + 1 / m, 1e-4 * result.cost) << solver;
    EXPECT_NEAR(result.trajectory.x(50)[column_of(loaded, "mass")], m, 1e-4) << solver;
  }
  for (const DerivativeComparison& derivative :
       check_derivatives(*loaded.built->problem, loaded.built->guess, {.knots_per_phase = 3}))
    EXPECT_LT(derivative.error, 1e-6);
}

TEST(FreeParameters, WorkWithFreeInitialStatesAndDurations) {
  // Covering 1 at the chosen speed costs the time and the squared speed: T + v² with T = 1/v.
  const Loaded loaded(R"(conddp: 1
parameters: {speed: {free: true, lower: 0.1, upper: 5}}
system: {states: [x], controls: [u], rate: {x: speed + u}}
initial_state: {}
integrator: rk4
phases:
  - {choose: none}
  - {name: way, knots: 20, duration: 1, free_duration: {lower: 0.1, upper: 10}}
costs:
  time: {residual: expression, rows: "1", activation: linear}
  still: {residual: control, weight: 1.0e5}
terminal:
  costs: {fast: {residual: expression, rows: [speed], weight: 2}}
  constraints: {there: {residual: expression, rows: [x], equals: 1}}
solver: {name: ipopt}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = answer_of(loaded, "ipopt");
  EXPECT_EQ(result.status, SolveStatus::converged);
  const double v = std::cbrt(0.5);
  EXPECT_NEAR(result.trajectory.x(3)[column_of(loaded, "speed")], v, 1e-3);
  EXPECT_NEAR(result.cost, 1 / v + v * v, 1e-3);
}

TEST(FreeParameters, AreStatesInDifferencesAndSeveralSystems) {
  const Loaded differences(
      replaced(replaced(replaced(kDrift, "rate: {x: c*(p + u)}", "next: {x: x + 0.05*(p + u)}"),
                        "integrator: rk4\n", ""),
               "choose: none", "choose: all, lower: {x: 0}, upper: {x: 0}"));
  ASSERT_TRUE(differences.built) << differences.all();
  EXPECT_NEAR(answer_of(differences, "altro").cost, 0.5, 1e-6);
  const Loaded several(
      replaced(replaced(kDrift, "system: {states: [x], controls: [u], rate: {x: c*(p + u)}}",
                        "systems:\n  a: {states: [x], controls: [u], rate: {x: p + u}}\n"
                        "  b: {states: {x: 1}, controls: [u], rate: {x: p + u}}"),
               "{knots: 20, duration: 1}",
               "{system: a, knots: 10, duration: 0.5}, {system: b, knots: 10, duration: 0.5}"));
  ASSERT_TRUE(several.built) << several.all();
  EXPECT_NEAR(answer_of(several, "altro").cost, 0.5, 1e-6);
}

TEST(FreeParameters, StateBoundsByNameDoNotCoverThem) {
  const Loaded loaded(
      replaced(kDrift, "terminal:\n",
               "constraints: {box: {bounds: state, lower: {x: -5}, upper: {x: 5}}}\nterminal:\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(answer_of(loaded, "altro").cost, 0.5, 1e-6);
}

TEST(FreeParameters, AreFixedByEqualBounds) {
  const Loaded loaded(std::string(kDrift), {"parameters.p.lower=0.25", "parameters.p.upper=0.25",
                                            "parameters.p.start=0.25"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(answer_of(loaded, "altro").cost, 0.625, 1e-6);
}

TEST(FreeParameters, StartInEveryKeyframeOfTheFirstGuess) {
  const Loaded loaded(replaced(
      kDrift, "solver:",
      "initial_guess: {states: {keyframes: [{time: 0, state: {values: {x: 0}}}, {time: 1, state: "
      "{state: [1]}}]}}\nsolver:"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Trajectory& guess = loaded.built->guess;
  const int p = column_of(loaded, "p");
  for (int k = 0; k <= guess.knots(); ++k) EXPECT_NEAR(guess.x(k)[p], 0.1, 1e-15) << k;
  EXPECT_EQ(answer_of(loaded, "altro").status, SolveStatus::converged);
}

TEST(FreeParameters, SettingsOfTheirStatesAreErrors) {
  const Loaded loaded(std::string(kDrift), {"initial_state.values.p=1"});
  EXPECT_FALSE(loaded.built);
  EXPECT_NE(loaded.all().find("'p' is free, and stands here again"), std::string::npos)
      << loaded.all();
}

TEST(FreeParameters, AreReadAgainFromTheExpandedFile) {
  const Loaded loaded{std::string(kDrift)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Loaded again(expanded_text(*loaded.built));
  ASSERT_TRUE(again.built) << again.all();
  EXPECT_EQ(answer_of(again, "altro").cost, answer_of(loaded, "altro").cost);
}

TEST(FreeParameters, HaveTheirPlaceInErrors) {
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {
      {"lower: -2, upper: 3", "lower: 4, upper: 3",
       "4:6: error: the lower bound 4 lies above the upper bound 3"},
      {"start: 0.1", "start: 4", "4:6: error: the start 4 does not lie between -2 and 3"},
      {"lower: -2, ", "", "lacks the key 'lower'"},
      {"free: true", "free: false", "error: "},
      {"weight: 2}}\n  constraints", "weight: =2*p}}\n  constraints",
       "error: this depends on a free parameter, which the solver chooses"},
      {"rate: {x: c*(p + u)}", "type: double_integrator",
       "error: 'p' is free, and free parameters"},
      {"residual: expression, rows: [p]", "residual: state",
       "error: free parameters are states, and this is on all of them"},
      {"residual: expression, rows: [p]", "residual: state, columns: '*'",
       "error: free parameters are states, and this is on all of them"},
      {"residual: expression, rows: [p]", "residual: state, columns: [x, '*']",
       "error: free parameters are states, and this is on all of them"},
      {"terminal:\n", "terminal:\n  lqr: initial\n",
       "error: no control moves the mode with eigenvalue 1 of 'p'"},
      {"solver:",
       "initial_guess: {states: {keyframes: [{time: 1, state: {values: {p: 1}}}]}}\nsolver:",
       "error: 'p' is free, and stands here again"},
      {"choose: none", "choose: x, lower: [-1, 0]",
       "8:29: error: beside free parameters these bounds are given by name"},
      {"initial_state: {}\n", "", "error: the key 'initial_state' is missing"},
      {"initial_state: {}", "initial_state: [3, 0]", "6:16: error: "},
      {"initial_state: {}", "initial_state: hello", "6:16: error: "},
      {"initial_state: {}", "initial_state: {values: 3}", "6:25: error: "},
      {"initial_state: {}", "initial_state: {values: {p: 1}}",
       "6:26: error: 'p' is free, and stands here again"},
      {"choose: none", "choose: none, lower: {p: -1}",
       "8:33: error: 'p' is free, and stands here again"},
      {"choose: none", "choose: none, upper: {p: 0}",
       "8:33: error: 'p' is free, and stands here again"},
      {"rate: {x: c*(p + u)}", "rate: {x: c*(p + u), p: 1}",
       "5:59: error: 'p' is free, and stands here again"},
      {"{knots: 20, duration: 1}", "{knots: 20, duration: 1}, {jump: {p: 2*p}}",
       "8:60: error: 'p' is free, and constant over the motion"},
      {"terminal:\n", "constraints: {box: {bounds: state, lower: -2, upper: 2}}\nterminal:\n",
       "10:43: error: free parameters are states, and these bounds are on all of them"},
      {"terminal:\n", "constraints: {box: {bounds: state, upper: {'*': 2}}}\nterminal:\n",
       "10:43: error: free parameters are states, and these bounds are on all of them"},
      {"terminal:\n", "constraints: {box: {bounds: state, upper: {'p*': 2, x: 3}}}\nterminal:\n",
       "10:44: error: free parameters are states, and 'p*' is on 'p', too"},
      {"residual: expression, rows: [p]", "residual: state, columns: [x, '*p']",
       "error: free parameters are states, and '*p' is on 'p', too"}};
  for (const Case& c : cases) {
    const Loaded loaded(replaced(kDrift, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_NE(loaded.all().find(c.message), std::string::npos) << c.message << '\n' << loaded.all();
  }
}

/// Unused names in a well-formed file.
constexpr std::string_view kUnused = R"(conddp: 1
name: spare
parameters:
  c: 1
  m: {free: true, lower: 0, upper: 1}
tables: {drag: {points: [0, 1, 2], values: [0, 1, 4]}}
systems:
  a: {states: [x], controls: [u], let: {spare: x, used: x}, rate: {x: u + used}}
  b: {states: [x], controls: [u], rate: {x: 2*u}}
initial_state: {values: {x: 1}}
phases: [{choose: none}, {system: a, knots: 4, dt: 0.1}]
costs:
  effort: {residual: expression, of: {z: {residual: control}, w: {residual: control}}, rows: z}
)";

TEST(UnusedNames, ReportUnusedNames) {
  EXPECT_EQ(warnings(std::string(kUnused)),
            "5:3: 'm' is free, and occurs in no equation, residual or payload ()\n"
            "9:3: no phase has the system 'b' ()\n"
            "6:10: nothing uses 'drag' ()\n"
            "8:41: nothing uses 'spare' ()\n"
            "13:63: nothing uses 'w' ()\n");
}

TEST(UnusedNames, ExcludeNamesInFormulasAndMasses) {
  EXPECT_EQ(warnings(std::string(kDrift)), "");
  EXPECT_EQ(warnings(R"(conddp: 1
parameters: {load: {free: true, lower: 0, upper: 5}}
robot: {urdf: robots/arm7.urdf, payloads: {link_7: {mass: =load, com: [0, 0, 0.1]}}}
initial_state: {joints: {joint_2: 0.4}}
phases: [{choose: none}, {knots: 4, dt: 0.02}]
costs: {effort: {residual: control}}
)"),
            "");
}

}  // namespace
}  // namespace conddp
