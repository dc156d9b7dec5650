// Expression residuals in problem files.
#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
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

/// Residual of the cost "own" at a knot with x = 0.5, v = 1.5, and u = 2 if a control exists.
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

TEST(ExpressionRows, NameSystemColumnsAndKnotTime) {
  const Loaded loaded{std::string(kRows)};
  const std::vector<double> r = rows_at(loaded, 2);
  ASSERT_EQ(r.size(), 3u);
  const double drag = 1 + 0.5 * 3 - 0.1875;  // the natural spline between (1, 1) and (2, 4)
  EXPECT_NEAR(r[0], 0.5 * 3 * 0.25 + 0.5 * 2 * 2.25 - drag, 1e-14);
  EXPECT_NEAR(r[1], 0.5 * 0.2, 1e-15);
  EXPECT_EQ(r[2], 2);
  EXPECT_NEAR(rows_at(loaded, 3)[1], 0.5 * 0.3, 1e-15);
}

TEST(ExpressionRows, SingleRowIsANumberWithAPart) {
  const auto rows = [](const std::string& row) {
    return rows_at(
        Loaded(replaced(kRows, "rows: [energy - drag(v), \"[x*t, u]\"]",
                        "of: {z: {residual: state, columns: [v]}}, rows: \"" + row + "\"")),
        0);
  };
  for (const char* row : {"2*z", "2*z[0]", "2*z[v]", "2*z.v"})
    EXPECT_EQ(rows(row), (std::vector<double>{3})) << row;
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
  EXPECT_EQ(named_with("weights: {pear: 1}").first_error(), "13:73: 'pear' fits none of the rows");
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
      {"energy - drag(v)", "energy - drg(v)", "13:47: unknown function 'drg'"},
      {"\"[x*t, u]\"", "\"[x*t, w]\"", "13:63: unknown name 'w'"},
      {"\"[x*t, u]\"", "[x, w]", "13:60: unknown name 'w'"},
      {"\"[x*t, u]\"", "2*t",
       "13:56: a row of a residual depends on the state or the control, and this does not"},
      {"\"[x*t, u]\"", "{a: 1}", "13:56: an expression is expected here, not "},
      {"rows: [energy - drag(v), \"[x*t, u]\"]", "rows: []", "13:37: there is no row"},
      {", rows: [energy - drag(v), \"[x*t, u]\"]", "", "13:8: 'costs.own' lacks the key 'rows'"},
      {"control}", "control, rows: [x]}", "12:37: the residual 'control' has no 'rows'"},
      {"solver:", "terminal: {costs: {end: {residual: expression, rows: [x, u]}}}\nsolver:",
       "14:36: this residual needs a control, and there is none at the terminal node"},
  };
  for (const WrongFile& c : cases) {
    const Loaded loaded(replaced(kRows, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_TRUE(loaded.first_error().starts_with(c.error)) << c.to << "\n" << loaded.all();
  }
}

TEST(ExpressionRows, WarnOnceAboutNonsmoothRows) {
  EXPECT_EQ(
      warnings(replaced(replaced(kRows, "[energy - drag(v)", "[abs(x)"), "m*v^2", "m*abs(v)*v")),
      "6:12: nothing uses 'drag' ()\n"
      "7:9: nothing uses 'energy' ()\n"
      "7:35: 'abs' has a kink at 0; smooth_abs has none ()\n"
      "13:38: 'abs' has a kink at 0; smooth_abs has none ()\n");
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

TEST(ExpressionRows, ExplainNamesOfJoints) {
  for (const char* row : {"slider", "q/slider"}) {
    const Loaded loaded(fmt::format(R"(conddp: 1
robot: {{urdf: robots/cartpole.urdf, actuation: {{joints: [slider]}}}}
initial_state: {{joints: {{hinge: 0.5}}}}
phases: [{{knots: 10, dt: 0.05}}]
costs: {{own: {{residual: expression, rows: "{}"}}}}
)",
                                    row));
    ASSERT_NE(loaded.error(), nullptr);
    EXPECT_EQ(loaded.error()->message, "unknown name 'slider'");
    EXPECT_EQ(loaded.error()->hint, "write 'q[slider]' or 'v[slider]' or 'u[slider]'");
  }
}

constexpr std::string_view kTip = R"(conddp: 1
robot: {urdf: robots/cartpole.urdf, actuation: {joints: [slider]}}
initial_state: {joints: {hinge: 0.5}}
phases: [{knots: 6, dt: 0.05}]
costs:
  own:
    residual: expression
    of: {tip: {residual: frame_position, frame: tip}, flow: {residual: frame_velocity, frame: tip}}
    rows:
      height: tip.z - 0.2*sin(q[hinge])
      reach: norm(tip)*u[slider]
      speed: flow.vx^2 + flow.vz^2
  plain: {residual: frame_position, frame: tip, reference: [0, 0, 0]}
solver: {name: ddp}
)";

TEST(ExpressionRows, NameTheRowsOfOtherResiduals) {
  const Loaded loaded{std::string(kTip)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const KnotView knot = problem.knot(2);
  const System& system = knot.model->system();
  const auto data = system.create_data(0.0);
  const double x[] = {0.3, 0.7, -0.4, 1.1}, u[] = {2}, zero[] = {0, 0, 0};
  system.evaluate(x, u, *data);
  double own[3], tip[3];
  knot.model->costs()[0].residual->evaluate({x, u, zero, *data}, own);
  knot.model->costs()[1].residual->evaluate({x, u, zero, *data}, tip);
  const double hinge = x[system.state_columns()[0].name == "q/hinge" ? 0 : 1];
  EXPECT_NEAR(own[0], tip[2] - 0.2 * std::sin(hinge), 1e-14);
  EXPECT_NEAR(own[1], std::hypot(tip[0], tip[1], tip[2]) * 2, 1e-14);
  EXPECT_GT(own[2], 0);
  for (const DerivativeComparison& derivative :
       check_derivatives(problem, loaded.built->guess, {.knots_per_phase = 3}))
    EXPECT_LT(derivative.error, 1e-9);
}

TEST(ExpressionRows, ReportUnsupportedResiduals) {
  const auto error = [](std::string_view from, std::string_view to) {
    return Loaded(replaced(kTip, from, to)).first_error();
  };
  EXPECT_EQ(error("frame: tip},", "frame: top},"), "8:49: the robot has no frame 'top'");
  EXPECT_EQ(
      error("of: {tip: {residual: frame_position, frame: tip}",
            "of: {tip: {residual: control_rate}"),
      "8:26: 'control_rate' is not a quantity of one state and control, which expressions read");
  EXPECT_EQ(error("{tip: {residual: frame_position, frame: tip}",
                  "{q: {residual: frame_position, frame: tip}"),
            "8:10: the name 'q' is taken");
  EXPECT_EQ(error("tip.z -", "tip.w -"), "10:19: unknown part 'w' of a vector of 3");
  EXPECT_EQ(error("residual: frame_velocity", "residual: frame_velocities").substr(0, 30),
            "8:72: unknown residual 'frame_");
}

TEST(ExpressionRows, CostTimeWithFreeDurations) {
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

/// The control change as an expression matches 'control_rate'.
TEST(ExpressionRows, NameThePreviousControl) {
  const std::string rate = replaced(
      replaced(kRows, "own: {residual: expression, rows: [energy - drag(v), \"[x*t, u]\"]}",
               "own: {residual: control_rate, weight: 3}\n  push: {residual: state}"),
      "{values: {x: 1}}", "{values: {x: 1}, previous_control: 0.7}");
  const Loaded a(rate), b(replaced(rate, "residual: control_rate",
                                   "residual: expression, rows: [\"u - previous[u]\"]"));
  ASSERT_TRUE(a.built && b.built) << a.all() << b.all();
  EXPECT_EQ(b.built->state_columns.back().name, "previous/u");
  const auto solved = [](const Loaded& loaded) {
    return solve(*loaded.built->problem, "box_fddp", {}, loaded.built->guess);
  };
  const SolveResult known = solved(a), result = solved(b);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.cost, known.cost, 1e-10 * known.cost);
  for (int k = 0; k < known.trajectory.knots(); ++k)
    EXPECT_NEAR(result.trajectory.u(k)[0], known.trajectory.u(k)[0], 1e-6);
  for (const DerivativeComparison& c : check_derivatives(*b.built->problem, result.trajectory))
    EXPECT_LT(c.error, 1e-9);
}

TEST(ExpressionRows, BoundControlChangesAndCostTheLastControl) {
  const std::string text = replaced(
      replaced(kRows, "own: {residual: expression, rows: [energy - drag(v), \"[x*t, u]\"]}",
               "push: {residual: state, weight: 9}"),
      "box_fddp",
      "altro}\nterminal: {costs: {last: {residual: expression, rows: [\"previous[u]\"], "
      "reference: [2], weight: 50}}}\nconstraints: {slow: {residual: expression, rows: "
      "[\"u - previous[u]\"], lower: [-0.3], upper: [0.3]}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve(*loaded.built->problem, "altro", {}, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  double before = 0;
  for (int k = 0; k < result.trajectory.knots(); ++k) {
    const double u = result.trajectory.u(k)[0];
    EXPECT_LE(std::abs(u - before), 0.3 + 1e-6);
    before = u;
  }
  EXPECT_NEAR(before, 1.2, 1e-5) << "as near to 2 as four steps lead";
}

TEST(ExpressionRows, NamePreviousControlsByJoint) {
  const std::string text = replaced(
      kTip, "solver:", "  change: {residual: expression, rows: [\"previous[slider]\"]}\nsolver:");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
}

TEST(ExpressionRows, ReportMisplacedPreviousControls) {
  const std::string rate =
      replaced(kRows, "[energy - drag(v), \"[x*t, u]\"]", "[\"u - previous[u]\"]");
  const auto error = [&](std::string_view from, std::string_view to) {
    return Loaded(replaced(rate, from, to)).first_error();
  };
  EXPECT_EQ(error("previous[u]", "previous[w]"), "13:52: unknown part 'w' of a vector of 1");
  EXPECT_NE(error("rows: [\"u - previous[u]\"]",
                  "of: {inner: {residual: expression, rows: [\"previous[u]\"]}}, rows: [inner]")
                .find("a residual that another one names has no 'previous'"),
            std::string::npos);
}

}  // namespace
}  // namespace conddp
