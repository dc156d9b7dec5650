// Phases with their own systems, and jumps between them.
#include <gtest/gtest.h>

#include "analysis/certificate/replay.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// From 1 to 0, first with x' = u, then with x' = 3 u. With constant u in each, 1 + u₁ + 3 u₂ = 0,
/// and ½ (u₁² + u₂²) has its minimum at u = −(1, 3)/10.
constexpr std::string_view kTwoSystems = R"(conddp: 1
name: two
systems:
  weak: {states: {x: m}, controls: {u: N}, rate: {x: u}}
  strong: {states: {x: m}, controls: {u: N}, rate: {x: 3*u}}
initial_state: {values: {x: 1}}
phases:
  - {name: first, system: weak, knots: 5, duration: 1}
  - {name: second, system: strong, knots: 4, duration: 1}
costs:
  effort: {residual: control}
terminal:
  constraints:
    zero: {residual: state}
solver: {name: proxddp, tolerances: {stationarity: 1.0e-10, constraint: 1.0e-10}}
)";

/// From 1 to 0 with x' = u and x⁺ = 2 x halfway: 2 (1 + u₁) + u₂ = 0 at u = −(0.8, 0.4).
constexpr std::string_view kJump = R"(conddp: 1
name: leap
parameters: {gain: 2}
system: {states: {x: m, y: m}, controls: {u: N}, rate: {x: u, y: 0}}
initial_state: {values: {x: 1, y: 7}}
phases:
  - {name: before, knots: 5, duration: 1}
  - {name: leap, jump: {x: gain*x}}
  - {name: after, knots: 4, duration: 1}
costs:
  effort: {residual: control}
terminal:
  constraints:
    zero: {residual: state, columns: x}
solver: {name: proxddp, tolerances: {stationarity: 1.0e-10, constraint: 1.0e-10}}
)";

SolveResult solved(const Loaded& loaded, const std::string& solver) {
  return solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
}

TEST(SystemsOfPhases, EachPhaseMovesLikeItsSystem) {
  const Loaded loaded{std::string(kTwoSystems)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& phases = loaded.built->problem->phases();
  EXPECT_NE(&phases[0].model->system(), &phases[1].model->system());
  for (const char* solver : {"altro", "proxddp", "intro", "ipopt"}) {
    const SolveResult result = solved(loaded, solver);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << result.message;
    EXPECT_NEAR(result.cost, 0.05, 1e-8) << solver;
    EXPECT_NEAR(result.trajectory.u(0)[0], -0.1, 1e-6) << solver;
    EXPECT_NEAR(result.trajectory.u(8)[0], -0.3, 1e-6) << solver;
    EXPECT_NEAR(result.trajectory.x(5)[0], 0.9, 1e-6) << solver;
  }
}

TEST(SystemsOfPhases, PhasesOfOneSystemShareIt) {
  const Loaded loaded(replaced(
      kTwoSystems, "costs:", "  - {name: third, system: weak, knots: 3, dt: 0.1}\ncosts:"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& phases = loaded.built->problem->phases();
  EXPECT_EQ(phases[0].model, phases[2].model);
}

TEST(SystemsOfPhases, JumpHasNoDurationOrControls) {
  const Loaded loaded{std::string(kJump)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_TRUE(problem.takes_no_time(5));
  EXPECT_FALSE(problem.takes_no_time(6));
  EXPECT_EQ(loaded.built->guess.nu(5), 0);
  for (const char* solver : {"altro", "proxddp", "ipopt"}) {
    const SolveResult result = solved(loaded, solver);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << result.message;
    EXPECT_NEAR(result.cost, 0.4, 1e-8) << solver;
    EXPECT_NEAR(result.trajectory.x(5)[0], 0.2, 1e-6) << solver;
    EXPECT_NEAR(result.trajectory.x(6)[0], 0.4, 1e-6) << solver;
    EXPECT_EQ(result.trajectory.x(9)[1], 7) << solver << ": what does not jump stays";
  }
}

TEST(SystemsOfPhases, ClosedFormSystemsJumpToo) {
  const Loaded loaded(replaced(replaced(kPendulum, "  - {name: second",
                                        "  - {jump: {omega: -0.5*omega}}\n  - {name: second"),
                               "box_ddp", "box_fddp"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solved(loaded, "box_fddp");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_EQ(result.trajectory.x(5)[0], result.trajectory.x(4)[0]);
  EXPECT_EQ(result.trajectory.x(5)[1], -0.5 * result.trajectory.x(4)[1]);
}

constexpr const char* kCollocationRules[] = {"trapezoidal", "hermite_simpson", "radau3", "radau5"};

std::string collocated(std::string_view text, const std::string& rule) {
  return replaced(text, "initial_state", "integrator: " + rule + "\ninitial_state");
}

/// Collocation rules are exact on these motions too; a jump has no steps.
TEST(SystemsOfPhases, AreCollocatedToTheSameOptimum) {
  for (const char* rule : kCollocationRules)
    for (const std::string_view text : {kTwoSystems, kJump}) {
      SCOPED_TRACE(rule);
      const Loaded loaded(collocated(text, rule));
      ASSERT_TRUE(loaded.built) << loaded.all();
      const ShootingProblem& problem = *loaded.built->problem;
      for (const Phase& phase : problem.phases())
        EXPECT_EQ(phase.model->constraints().empty(), phase.name == "leap") << phase.name;
      for (const char* solver : {"altro", "proxddp", "intro", "ipopt"}) {
        const SolveResult result = solved(loaded, solver);
        ASSERT_EQ(result.status, SolveStatus::converged) << solver << result.message;
        EXPECT_NEAR(result.cost, text == kJump ? 0.4 : 0.05, 1e-8) << solver;
        EXPECT_NEAR(result.trajectory.x(5)[0], text == kJump ? 0.2 : 0.9, 1e-6) << solver;
        EXPECT_LT(replay(problem, result.trajectory, result.feedback.K).controls.deviation, 1e-6);
      }
    }
}

TEST(SystemsOfPhases, PhasesOfOneSystemShareItsCollocation) {
  const Loaded loaded(replaced(collocated(kTwoSystems, "radau3"), "costs:",
                               "  - {name: third, system: weak, knots: 3, dt: 0.1}\ncosts:"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto& phases = loaded.built->problem->phases();
  EXPECT_EQ(phases[0].model, phases[2].model);
}

TEST(SystemsOfPhases, ExpansionIsEquivalent) {
  for (const std::string& text : {std::string(kTwoSystems), std::string(kJump),
                                  collocated(kTwoSystems, "radau5"), collocated(kJump, "radau5")}) {
    const Loaded loaded(text);
    ASSERT_TRUE(loaded.built) << loaded.all();
    const OrderedJson expanded = expand_problem(*loaded.built);
    const Loaded again(expanded.dump());
    ASSERT_TRUE(again.built) << again.all() << expanded;
    EXPECT_EQ(expand_problem(*again.built), expanded);
    EXPECT_EQ(solved(again, "proxddp").cost, solved(loaded, "proxddp").cost);
  }
}

TEST(SystemsOfPhases, UnitsAgreeIfAllSystemsHaveThem) {
  for (const char* same : {"states: {x: m}", "states: {x: 1}", "states: [x]"}) {
    const Loaded loaded(
        replaced(kTwoSystems, "strong: {states: {x: m}", std::string("strong: {") + same));
    EXPECT_TRUE(loaded.built) << loaded.all();
  }
}

TEST(SystemsOfPhases, ReportsPhasesWithoutASystem) {
  const std::string text(kJump);
  const Loaded loaded(replaced(
      text, "system: {states: {x: m, y: m}, controls: {u: N}, rate: {x: u, y: 0}}", "systems: {}"));
  EXPECT_TRUE(loaded.first_error().starts_with("4:10: there is no system")) << loaded.all();
  EXPECT_EQ(loaded.all().find("jumps are for"), std::string::npos) << loaded.all();
}

TEST(SystemsOfPhases, ReportsMistakesAtTheirPlaces) {
  struct {
    std::string_view text, from, to, error;
  } const cases[] = {
      {kTwoSystems, "system: weak", "system: week", "8:27: unknown system 'week'"},
      {kTwoSystems, "system: weak, ", "",
       "8:12: the phase 'first' does not say which system moves"},
      {kTwoSystems, "strong: {states: {x: m}", "strong: {states: {x: cm}",
       "5:3: 'x' is in m in 'weak' and in cm in 'strong'"},
      {kTwoSystems, "controls: {u: N}, rate: {x: 3*u}", "controls: {u: kN}, rate: {x: 3*u}",
       "5:3: 'u' is in N in 'weak' and in kN in 'strong'"},
      {kPendulum,
       "system: {type: pendulum}\ninitial_state: {values: {theta: 0.1}}\nintegrator: rk4\nphases:",
       "parameters: {omega: 3}\nsystem: {type: pendulum}\ninitial_state: {values: {theta: "
       "0.1}}\nphases:\n  - {jump: {theta: -theta}}",
       "3:14: the name 'omega' is taken"},
      {kTwoSystems, "rate: {x: 3*u}", "next: {x: 3*u}",
       "5:3: 'strong' is of another kind than the first system"},
      {kTwoSystems, "systems:", "system: {type: pendulum}\nsystems:",
       "4:1: 'system' and 'systems' exclude each other"},
      {kJump, "knots: 5,", "knots: 5, system: weak,",
       "7:38: the file has no 'systems' of which a phase could have one"},
      {kJump, "{x: gain*x}", "{z: gain*x}", "8:25: there is no state 'z' that could jump"},
      {kJump, "{x: gain*x}", "{x: gian*x}", "8:28: unknown name 'gian'"},
      {kJump, "{x: gain*x}}", "{x: gain*x}, knots: 3}",
       "8:44: a jump takes no time: it has no 'knots'"},
      {kJump, "terminal:", "  early: {residual: control, phases: [leap]}\nterminal:",
       "12:21: the residual 'control' needs a control, and the jump 'leap' has none"},
      {kCartpole, "knots: 5, dt: 0.1}]", "jump: {slider: 0}}, {knots: 5, dt: 0.1}]",
       "8:29: jumps are for systems, not for robots"},
  };
  for (const auto& c : cases) {
    const Loaded loaded(replaced(c.text, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_TRUE(loaded.first_error().starts_with(c.error)) << c.to << "\n" << loaded.all();
  }
}

}  // namespace
}  // namespace conddp
