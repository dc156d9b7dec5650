// Costs and constraints at instantaneous knots, and empty lists of names.
#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

constexpr std::string_view kJumpOfABall = R"(conddp: 1
system: {states: {h: m, v: m/s}, controls: {u: N}, rate: {h: v, v: u - 10}}
initial_state: {values: {h: 5}}
phases: [{name: one, knots: 10, duration: 1}, {name: j, jump: {v: 3}}, {name: two, knots: 10, duration: 1}]
costs: {effort: {residual: control}}
constraints: {gate: {residual: expression, rows: h, WHERE, equals: 2}}
)";

double cost_with_gate(const std::string& where) {
  const Loaded loaded(replaced(kJumpOfABall, "WHERE", where));
  EXPECT_TRUE(loaded.built) << loaded.all();
  if (!loaded.built) return 0;
  const SolveResult result =
      solve(*loaded.built->problem, "altro", loaded.spec->solver.options, loaded.built->guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  return result.cost;
}

TEST(InstantKnots, ConstraintAtAJumpKnotHolds) {
  const double by_phase = cost_with_gate("phases: j");
  EXPECT_GT(by_phase, 1);
  EXPECT_NEAR(cost_with_gate("knots: [10]"), by_phase, 1e-9 * by_phase);
  EXPECT_NEAR(cost_with_gate("phases: j, knots: [10]"), by_phase, 1e-9 * by_phase);
}

TEST(InstantKnots, ExpansionIsEquivalent) {
  const Loaded loaded(replaced(kJumpOfABall, "WHERE", "knots: [10]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const OrderedJson expanded = expand_problem(*loaded.built);
  const Loaded again(expanded.dump());
  ASSERT_TRUE(again.built) << again.all() << expanded;
  EXPECT_EQ(expand_problem(*again.built), expanded);
  EXPECT_EQ(again.built->problem->constraints()[0].node, 10);
}

TEST(InstantKnots, OnlyNamedKnotsGetTheConstraint) {
  const Loaded loaded(replaced(kJumpOfABall, "WHERE", "knots: [9, 10]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  std::vector<int> nodes;
  for (const NodeConstraint& c : loaded.built->problem->constraints()) nodes.push_back(c.node);
  EXPECT_EQ(nodes, (std::vector<int>{9, 10}));
}

TEST(InstantKnots, CostAtAJumpKnotCounts) {
  const Loaded loaded(
      replaced(replaced(kJumpOfABall, "WHERE", "phases: j"), "{residual: control}",
               "{residual: control}, low: {residual: expression, rows: h, knots: [10]}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->knot(10).model->costs().size(), 1u);
}

TEST(InstantKnots, InitialChoiceKnotAcceptsNoConstraints) {
  const Loaded loaded(replaced(replaced(kJumpOfABall, "WHERE", "knots: [0]"), "phases: [",
                               "phases: [{choose: all}, "));
  EXPECT_NE(loaded.first_error().find("is not a place for costs and constraints"),
            std::string::npos)
      << loaded.all();
}

TEST(InstantKnots, EmptyListsAreReported) {
  EXPECT_NE(Loaded(replaced(kJumpOfABall, "WHERE", "knots: []"))
                .first_error()
                .find("an empty list names no knot"),
            std::string::npos);
  EXPECT_NE(Loaded(replaced(kJumpOfABall, "WHERE", "phases: []"))
                .first_error()
                .find("an empty list names no phase"),
            std::string::npos);
}

constexpr std::string_view kWithoutControl = R"(conddp: 1
system: {states: [x], controls: [], rate: {x: -x}}
initial_state: {values: {x: 1}}
phases: [{name: only, knots: 5, duration: 1}]
costs: {x: {residual: state}}
)";

TEST(WithoutControl, ResidualsAndBoundsOfTheControlAreReported) {
  ASSERT_TRUE(Loaded(std::string(kWithoutControl)).built);
  for (const char* residual : {"control", "control_rate"}) {
    const Loaded loaded(
        replaced(kWithoutControl, "residual: state", "residual: " + std::string(residual)));
    EXPECT_EQ(loaded.first_error(), fmt::format("5:23: the residual '{}' needs a control, and the "
                                                "system has none",
                                                residual))
        << loaded.all();
  }
  const Loaded bounded(std::string(kWithoutControl) +
                       "constraints: {range: {bounds: control, lower: 0}}\n");
  EXPECT_EQ(bounded.first_error(), "6:15: the system has no control that could have bounds")
      << bounded.all();
}

}  // namespace
}  // namespace conddp
