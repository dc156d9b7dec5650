// Residuals of expressions in problem files.
#include <gtest/gtest.h>

#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

constexpr std::string_view kRows = R"(conddp: 1
system:
  states: {x: m, v: m/s}
  controls: {u: N}
  parameters: {k: 3, m: 2}
  tables: {drag: {points: [0, 1, 2], values: [0, 1, 4]}}
  let: {energy: 0.5*k*x^2 + 0.5*m*v^2}
  rate: {x: v, v: (u - k*x)/m}
initial_state: {values: {x: 1}}
phases: [{knots: 4, dt: 0.1}]
costs:
  effort: {residual: control}
  own: {residual: expression, rows: [energy - drag(v), "[x*t, u]"]}
solver: {name: box_fddp}
)";

/// The residual of the cost "own" at a knot, with x = 0.5, v = 1.5, u = 2 where there is a control.
std::vector<double> rows_at(const Loaded& loaded, int knot) {
  EXPECT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const KnotView view = problem.knot(knot);
  const double x[] = {0.5, 1.5}, u = 2;
  const auto data = view.model->system().create_data(0.0);
  for (const CostTerm& cost : view.model->costs())
    if (cost.name == "own") {
      std::vector<double> r(cost.residual->size());
      cost.residual->evaluate({x, &u, view.parameters + cost.parameters, *data}, r.data());
      return r;
    }
  return {};
}

TEST(ExpressionRows, NameWhatTheSystemNamesAndTheTimeOfTheKnot) {
  const Loaded loaded{std::string(kRows)};
  const std::vector<double> r = rows_at(loaded, 2);
  ASSERT_EQ(r.size(), 3u);
  const double drag = 1 + 0.5 * 3 - 0.1875;  // the natural spline between (1, 1) and (2, 4)
  EXPECT_NEAR(r[0], 0.5 * 3 * 0.25 + 0.5 * 2 * 2.25 - drag, 1e-14);
  EXPECT_NEAR(r[1], 0.5 * 0.2, 1e-15);
  EXPECT_EQ(r[2], 2);
  EXPECT_NEAR(rows_at(loaded, 3)[1], 0.5 * 0.3, 1e-15);
}

TEST(ExpressionRows, MayBeOneTextAListOrNames) {
  const auto with = [](const std::string& rows) {
    return replaced(kRows, "[energy - drag(v), \"[x*t, u]\"]", rows);
  };
  EXPECT_EQ(rows_at(Loaded(with("2*x")), 0), (std::vector<double>{1}));
  EXPECT_EQ(rows_at(Loaded(with("[[x, v]]")), 0), (std::vector<double>{0.5, 1.5}));
  const std::string named = with("{speed: v, pair: [u, x]}");
  EXPECT_EQ(rows_at(Loaded(named), 0), (std::vector<double>{1.5, 2, 0.5}));
  const auto named_with = [&](const std::string& keys) {
    return Loaded(replaced(named, "pair: [u, x]}", "pair: [u, x]}, " + keys));
  };
  EXPECT_EQ(rows_at(named_with("reference: {speed: 1, pair/1: 0.25}"), 0),
            (std::vector<double>{0.5, 2, 0.25}));
  EXPECT_EQ(named_with("weights: {pear: 1}").first_error(),
            "12:92: there is no 'pear' among the rows");
}

TEST(ExpressionRows, ReferencesMayChangeOverTime) {
  const std::string text = replaced(kRows, "[energy - drag(v), \"[x*t, u]\"]",
                                    "[x], reference: {times: [0, 0.4], values: [0, 4]}");
  EXPECT_NEAR(rows_at(Loaded(text), 1)[0], 0.5 - 1, 1e-15);
  EXPECT_NEAR(rows_at(Loaded(text), 3)[0], 0.5 - 3, 1e-15);
}

TEST(ExpressionRows, ErrorsPointIntoTheExpression) {
  struct WrongFile {
    std::string from, to, error;
  };
  const WrongFile cases[] = {
      {"energy - drag(v)", "energy - drg(v)", "12:47: unknown function 'drg'"},
      {"\"[x*t, u]\"", "\"[x*t, w]\"", "12:64: unknown name 'w'"},
      {"\"[x*t, u]\"", "[x, w]", "12:60: unknown name 'w'"},
      {"\"[x*t, u]\"", "2*t",
       "12:56: a row of a residual depends on the state or the control, and this does not"},
      {"\"[x*t, u]\"", "{a: 1}", "12:56: an expression is expected here, not a mapping"},
      {"rows: [energy - drag(v), \"[x*t, u]\"]", "rows: []", "12:42: there is no row"},
      {", rows: [energy - drag(v), \"[x*t, u]\"]", "", "12:8: 'costs.own' lacks the key 'rows'"},
      {"control}", "control, rows: [x]}", "11:37: the residual 'control' has no 'rows'"},
      {"solver:", "terminal: {costs: {end: {residual: expression, rows: [x, u]}}}\nsolver:",
       "13:36: this residual needs a control, and there is none at the terminal node"},
      {"[{knots: 4, dt: 0.1}]",
       "[{choose: none}, {knots: 4, duration: 1, free_duration: {lower: 0.5, upper: 2}}]",
       "12:20: where durations are free, the time 't' of a knot is not given"},
  };
  for (const WrongFile& c : cases) {
    const Loaded loaded(replaced(kRows, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_TRUE(loaded.first_error().starts_with(c.error)) << c.to << "\n" << loaded.all();
  }
}

TEST(ExpressionRows, WarnOfWhatIsNotSmoothOnce) {
  EXPECT_EQ(
      warnings(replaced(replaced(kRows, "[energy - drag(v)", "[abs(x)"), "m*v^2", "m*abs(v)*v")),
      "7:32: 'abs' has a kink at 0; smooth_abs has none ()\n"
      "12:39: 'abs' has a kink at 0; smooth_abs has none ()\n");
}

TEST(ExpressionRows, ConstrainClosedFormSystemsInAnySet) {
  const Loaded loaded(R"(conddp: 1
system: {type: unicycle}
initial_state: {}
phases: [{knots: 40, dt: 0.1}]
costs: {effort: {residual: control, weight: 0.1}}
constraints:
  speed: {residual: expression, rows: v^2 + omega^2, upper: 1.5}
  posts: {residual: expression, rows: {x: x, y: y}, at_least: 0.4, centers: [[1, 0.1], [2, -0.3]]}
terminal:
  constraints: {there: {residual: expression, rows: {x: x, bearing: y - sin(theta)}, equals: {x: 3, bearing: 0}}}
solver: {name: altro}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const char* name : {"altro", "proxddp", "ipopt"}) {
    const SolveResult result =
        solve(*loaded.built->problem, name, loaded.spec->solver.options, loaded.built->guess);
    ASSERT_EQ(result.status, SolveStatus::converged) << name;
    for (int k = 1; k < 40; ++k) {
      const auto x = result.trajectory.x(k), u = result.trajectory.u(k);
      EXPECT_LT(u[0] * u[0] + u[1] * u[1], 1.5 + 1e-6) << name;
      EXPECT_GT(std::hypot(x[0] - 1, x[1] - 0.1), 0.4 - 1e-6) << name;
      EXPECT_GT(std::hypot(x[0] - 2, x[1] + 0.3), 0.4 - 1e-6) << name;
    }
    const auto end = result.trajectory.x(40);
    EXPECT_NEAR(end[0], 3, 1e-6) << name;
    EXPECT_NEAR(end[1], std::sin(end[2]), 1e-6) << name;
  }
}

TEST(ExpressionRows, NameTheJointsOfRobots) {
  const Loaded loaded(R"(conddp: 1
robot: {urdf: robots/cartpole.urdf, actuation: {joints: [slider]}}
initial_state: {joints: {hinge: 0.5}}
phases: [{knots: 10, dt: 0.05}]
constraints:
  power: {residual: expression, rows: "u[slider]*v[slider] + q[hinge]", lower: -1, upper: 1}
solver: {name: altro}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const KnotView knot = loaded.built->problem->knot(3);
  const auto data = knot.model->system().create_data(0.0);
  const double x[] = {1, 2, 3, 4}, u[] = {5}, zero[] = {0};
  const ConstraintTerm& power = knot.model->constraints()[0];
  double r;
  power.residual->evaluate({x, u, zero, *data}, &r);
  const auto columns = knot.model->system().state_columns();
  const int slider = columns[0].name == "q/slider" ? 0 : 1;
  EXPECT_EQ(r, 5 * x[2 + slider] + x[1 - slider]);
}

TEST(ExpressionRows, CostTimeWhereDurationsAreFree) {
  const Loaded loaded(R"(conddp: 1
system: {type: double_integrator, dimension: 1}
initial_state: {}
integrator: rk2
phases: [{choose: none}, {knots: 20, duration: 3, free_duration: {lower: 0.1, upper: 10}}]
costs: {time: {residual: expression, rows: sqrt(2)}}
constraints: {force: {bounds: control, lower: -2, upper: 2}}
terminal: {constraints: {there: {residual: state, reference: [1, 0]}}}
solver: {name: ipopt}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result =
      solve(*loaded.built->problem, "ipopt", loaded.spec->solver.options, loaded.built->guess);
  EXPECT_NEAR(result.cost, 2 * std::sqrt(0.5), 1e-6);
}

}  // namespace
}  // namespace conddp
