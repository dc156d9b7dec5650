// The clock of time-dependent systems, which is part of the state only by name.
#include "analysis/comparison/random_instance.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "systems/system.hpp"

namespace conddp {
namespace {

constexpr std::string_view kFirstOrder = R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u + 0.001*t}}
initial_state: {values: {x: 1}}
phases: [{name: only, knots: 20, duration: 2}]
costs: {u: {residual: control}}
terminal: {constraints: {end: {residual: state}}}
)";

constexpr std::string_view kSecondOrder = R"(conddp: 1
system: {positions: [x], velocities: [v], controls: [u], acceleration: {v: u + 0.1*sin(t)}}
initial_state: {}
phases: [{name: only, knots: 20, duration: 1}]
costs: {u: {residual: control}}
terminal: {constraints: {end: {residual: state, reference: [1, 0]}}}
)";

constexpr std::string_view kDuffing = R"(conddp: 1
system: {states: [x, v], controls: [u], rate: {x: v, v: -x - 0.5*v + cos(2*t) + u}}
initial_state: {}
integrator: rk4
phases: [{choose: all}, {name: period, knots: 100, duration: 3.14159265358979}]
costs: {u: {residual: control}}
terminal: {constraints: {end: {residual: cycle}}}
)";

SolveResult answer_by_altro(const Loaded& loaded) {
  return solve(*loaded.built->problem, "altro", loaded.spec->solver.options, loaded.built->guess);
}

/// Rows of the constraint of this name at its first node; 0 if absent.
int rows_named(const Loaded& loaded, std::string_view name) {
  for (const NodeConstraint& c : loaded.built->problem->constraints())
    if (c.term->name == name) return c.term->rows;
  return 0;
}

TEST(Clock, StateConstraintLeavesTimeFree) {
  const Loaded loaded{std::string(kFirstOrder)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(rows_named(loaded, "end"), 1);
  const SolveResult result = answer_by_altro(loaded);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.trajectory.x(20)[0], 0, 1e-6);
  EXPECT_NEAR(result.trajectory.x(20)[1], 2, 1e-9) << "the clock";
}

TEST(Clock, SecondOrderClockIsOutsideTheState) {
  const Loaded loaded{std::string(kSecondOrder)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(rows_named(loaded, "end"), 2);
  EXPECT_EQ(answer_by_altro(loaded).status, SolveStatus::converged);
}

TEST(Clock, IsPartOfTheStateIfNamed) {
  const Loaded loaded(replaced(kFirstOrder, "end: {residual: state}",
                               "end: {residual: state, columns: [\"*\", t], reference: [0, 2]}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(rows_named(loaded, "end"), 2);
  const Loaded pattern(
      replaced(kFirstOrder, "{residual: state}", "{residual: state, columns: \"*\"}"));
  ASSERT_TRUE(pattern.built) << pattern.all();
  EXPECT_EQ(rows_named(pattern, "end"), 1);
}

TEST(Clock, IsExcludedFromListsOfTheState) {
  const Loaded loaded(replaced(kFirstOrder, "{values: {x: 1}}", "{state: [1]}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->initial_state(), (std::vector<double>{1, 0}));
  const Loaded wrong(replaced(kFirstOrder, "{values: {x: 1}}", "{state: [1, 2, 3]}"));
  EXPECT_NE(wrong.first_error().find("the state has 1 number, not 3"), std::string::npos)
      << wrong.all();
}

TEST(Clock, HasBoundsOnlyByItsOwnName) {
  const auto bounded = [](const std::string& bounds) {
    return replaced(kFirstOrder, "terminal:",
                    "constraints: {range: {bounds: state, " + bounds + "}}\nterminal:");
  };
  for (const char* bounds : {"lower: -1, upper: 1", "lower: {\"*\": -1}", "lower: [-1]"}) {
    const Loaded loaded(bounded(bounds));
    ASSERT_TRUE(loaded.built) << loaded.all();
    EXPECT_EQ(rows_named(loaded, "range"), 1) << bounds;
  }
  const Loaded named(bounded("upper: {x: 1, t: 3}"));
  ASSERT_TRUE(named.built) << named.all();
  EXPECT_EQ(rows_named(named, "range"), 2);
}

TEST(Clock, IsNeitherChosenNorPartOfACycle) {
  const Loaded loaded{std::string(kDuffing)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->nu(0), 2);
  EXPECT_EQ(rows_named(loaded, "end"), 2);
  const SolveResult result = answer_by_altro(loaded);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  // x'' = -x - x'/2 + cos(2t) has the periodic solution x = Re(exp(2it)/(-3 + i)).
  EXPECT_NEAR(result.trajectory.x(1)[0], -0.3, 1e-5);
  EXPECT_NEAR(result.trajectory.x(1)[1], 0.2, 1e-5);
  EXPECT_LT(result.cost, 1e-12);
}

TEST(Clock, IsUnaffectedByPerturbedInitialStates) {
  const Loaded loaded{std::string(kSecondOrder)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double> x =
      perturb_initial_state(*loaded.built->problem, 0.5, 1).initial_state();
  EXPECT_NE(x[0], 0);
  EXPECT_EQ(x[1], 0) << "t";
  EXPECT_NE(x[2], 0);
  EXPECT_EQ(x[3], 1) << "t_rate";
}

TEST(Clock, StateWithRateNameAloneIsOrdinary) {
  const Loaded loaded(
      replaced(replaced(kFirstOrder, "[x]", "[x, t_rate]"), "u + 0.001*t", "u, t_rate: u"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(rows_named(loaded, "end"), 2);
  EXPECT_TRUE(other_coordinates(*loaded.built->plant.system).empty());
}

constexpr std::string_view kTurn = R"(conddp: 1
system:
  states: {q: unit_quaternion, wx: rad/s, wy: rad/s, wz: rad/s}
  controls: {ux: N*m, uy: N*m, uz: N*m}
  rate: {q: "[wx, wy, wz]", wx: ux + 0.1*sin(t), wy: uy, wz: uz}
initial_state: {}
phases: [{name: turn, knots: 30, duration: 1}]
costs: {u: {residual: control}}
terminal:
  constraints:
    there: {residual: state, reference: {values: {q/x: =sin(pi/4), q/w: =cos(pi/4)}}}
)";

TEST(ChosenColumns, RotationsAreChosenByNameOrAllColumns) {
  std::vector<double> costs;
  for (const char* columns : {"", ", columns: [q, wx, wy, wz]", ", columns: [\"q/*\", \"w*\"]"}) {
    const Loaded loaded(
        replaced(kTurn, "residual: state", "residual: state" + std::string(columns)));
    ASSERT_TRUE(loaded.built) << loaded.all();
    EXPECT_EQ(rows_named(loaded, "there"), 6);
    const SolveResult result = answer_by_altro(loaded);
    ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
    EXPECT_NEAR(std::abs(result.trajectory.x(30)[0]), std::sqrt(0.5), 1e-6);
    costs.push_back(result.cost);
  }
  EXPECT_EQ(costs[0], costs[1]);
  EXPECT_EQ(costs[0], costs[2]);
}

TEST(ChosenColumns, ReportsAPartOfARotation) {
  const Loaded loaded(replaced(kTurn, "residual: state", "residual: state, columns: [q/x, wx]"));
  EXPECT_NE(loaded.first_error().find("'q/x' is part of a rotation and cannot be chosen alone"),
            std::string::npos)
      << loaded.all();
}

}  // namespace
}  // namespace conddp
