#include <fmt/format.h>
#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/plant/memory_need.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// The small pendulum with constraints and altro.
std::string with(const std::string& constraints, const std::string& terminal = "") {
  std::string text = replaced(kPendulum, "name: box_ddp", "name: altro");
  text = replaced(text, "constraints:\n", "constraints:\n" + constraints);
  if (!terminal.empty())
    text = replaced(text, "terminal:\n", "terminal:\n  constraints:\n" + terminal);
  return text;
}

const std::string kStanding = R"(conddp: 1
robot: {urdf: robots/quadruped.urdf, base: floating}
contacts:
  LF: {frame: lf_foot, friction: 0.5}
  RF: {frame: rf_foot, friction: 0.5, max_normal_force: 300}
initial_state: {base: {position: [0, 0, 0.57]}}
phases:
  - {name: stand, knots: 3, dt: 0.1, contacts: all}
  - {name: fly, knots: 2, dt: 0.1}
costs: {effort: {residual: control}}
)";

std::vector<NodeConstraint> named(const ShootingProblem& problem, const std::string& name) {
  std::vector<NodeConstraint> list;
  for (const NodeConstraint& c : problem.constraints())
    if (c.term->name == name) list.push_back(c);
  return list;
}

/// Values of a constraint at its first node with every state at the initial one.
std::vector<double> initial_values(const ShootingProblem& problem, const std::string& name) {
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(problem.create_trajectory(), evaluation);
  const auto list = named(problem, name);
  if (list.empty()) return {};
  const auto values = evaluation.constraint.segment(list[0].row, list[0].term->rows);
  return {values.begin(), values.end()};
}

TEST(Constraints, PositionBoundsWithoutReferenceAreInTheWorld) {
  const Loaded loaded(
      kStanding +
      "constraints:\n"
      "  foot: {residual: frame_position, frame: lf_foot, lower: {z: 0.05}, knots: [2]}\n"
      "  mass: {residual: com_position, equals: {x: 0.1}, knots: [2]}\n");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(named(problem, "foot").front().lower[2], 0.05);
  const Loaded measured(
      kStanding +
      "constraints:\n"
      "  foot: {residual: frame_position, frame: lf_foot, reference: [0, 0, 0], "
      "lower: {z: 0.05}, knots: [2]}\n"
      "  mass: {residual: com_position, reference: [0, 0, 0], equals: {x: 0.1}, knots: [2]}\n");
  ASSERT_TRUE(measured.built) << measured.all();
  for (const char* name : {"foot", "mass"}) {
    EXPECT_FALSE(initial_values(problem, name).empty());
    EXPECT_EQ(initial_values(problem, name), initial_values(*measured.built->problem, name));
  }
}

TEST(Constraints, StateBoundsSkipOnlyTheFirstNode) {
  const Loaded loaded(
      with("  speed: {bounds: velocity, lower: -2, upper: 5}\n"
           "  here: {bounds: state, lower: {theta: -1}, phases: second}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto speed = named(*loaded.built->problem, "speed");
  ASSERT_EQ(speed.size(), 10u);
  EXPECT_EQ(speed.front().node, 1);
  EXPECT_EQ(speed.back().node, 10);
  EXPECT_EQ(speed[0].term->rows, 1);
  EXPECT_EQ(speed[0].lower[0], -2);
  EXPECT_EQ(speed[0].upper[0], 5);
  const auto here = named(*loaded.built->problem, "here");
  ASSERT_EQ(here.size(), 6u);
  EXPECT_EQ(here.front().node, 4);
  EXPECT_EQ(here.back().node, 9);
}

TEST(Constraints, NullIsNoBoundForAnyQuantity) {
  const Loaded loaded(
      with("  speed: {bounds: velocity, lower: null, upper: 5}\n"
           "  spin: {residual: state, columns: omega, lower: -4, upper: null}\n"
           "  push: {bounds: control, lower: null, upper: 7}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto speed = named(*loaded.built->problem, "speed");
  EXPECT_EQ(speed[0].lower[0], -kUnlimited);
  EXPECT_EQ(speed[0].upper[0], 5);
  const auto spin = named(*loaded.built->problem, "spin");
  EXPECT_EQ(spin[0].lower[0], -4);
  EXPECT_EQ(spin[0].upper[0], kUnlimited);
  const OrderedJson expanded = expand_problem(*loaded.built);
  EXPECT_TRUE(expanded["constraints"]["speed"]["lower"].is_null());
  EXPECT_TRUE(Loaded(expanded.dump()).built);
}

TEST(Constraints, UrdfLimitsBoundTheirCoordinates) {
  const Loaded loaded(std::string(kCartpole) +
                      "constraints: {rail: {bounds: configuration, from: urdf}}\n"
                      "solver: {name: altro}\n");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto rail = named(*loaded.built->problem, "rail");
  ASSERT_FALSE(rail.empty());
  const auto limits = loaded.built->plant.multibody()->limits(0);
  EXPECT_EQ(rail[0].lower[0], limits.lower);
  EXPECT_EQ(rail[0].upper[0], limits.upper);
}

TEST(Constraints, ResidualsTakeEqualitiesBoundsLengthsAndCones) {
  const Loaded loaded(
      with("  fixed: {residual: state, equals: {theta: 0.2}, knots: [2, 3]}\n"
           "  between: {residual: state, columns: omega, lower: -1, upper: [1]}\n"
           "  far: {residual: state, reference: [4, 0], at_least: 1, at_most: 9}\n"
           "  cone: {residual: state, cone: second_order, slope: 2, knots: [5]}\n",
           "    goal: {residual: state, reference: [1, 0]}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const auto fixed = named(problem, "fixed");
  ASSERT_EQ(fixed.size(), 2u);
  EXPECT_EQ(fixed[0].node, 2);
  EXPECT_EQ(fixed[0].lower[0], 0.2);
  EXPECT_EQ(fixed[0].upper[0], 0.2);
  EXPECT_TRUE(std::isinf(fixed[0].upper[1]));
  EXPECT_EQ(named(problem, "between")[0].term->rows, 1);
  const auto far = named(problem, "far");
  EXPECT_EQ(far[0].term->kind, ConstraintKind::norm);
  EXPECT_EQ(far[0].lower[0], 1);
  EXPECT_EQ(far[0].upper[0], 9);
  const auto cone = named(problem, "cone");
  ASSERT_EQ(cone.size(), 1u);
  EXPECT_EQ(cone[0].term->kind, ConstraintKind::second_order_cone);
  EXPECT_EQ(cone[0].term->slope, 2);
  const auto goal = named(problem, "goal");
  ASSERT_EQ(goal.size(), 1u);
  EXPECT_EQ(goal[0].node, problem.knots());

  Evaluation evaluation(problem);
  Trajectory t = problem.create_trajectory();
  t.x(problem.knots()) << 1.5, -2;
  Evaluator(problem).evaluate(t, evaluation);
  EXPECT_EQ(evaluation.constraint[goal[0].row], 0.5);
  EXPECT_EQ(evaluation.constraint[goal[0].row + 1], -2);
}

TEST(Constraints, FrictionConesHoldOnlyDuringContact) {
  const Loaded loaded(kStanding +
                      "constraints:\n"
                      "  exact: {residual: friction_cone, cone: second_order, safety: 0.8}\n"
                      "  same: {residual: contact_force, contacts: LF, cone: second_order}\n"
                      "  pyramid: {residual: friction_cone, contacts: LF, faces: 6}\n"
                      "solver: {name: altro}\n");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const auto exact = named(problem, "exact");
  // Three knots: a cone of each foot, and one limit of a normal force.
  ASSERT_EQ(exact.size(), 9u);
  EXPECT_EQ(exact[0].term->kind, ConstraintKind::second_order_cone);
  EXPECT_EQ(exact[2].term->kind, ConstraintKind::bounds);
  EXPECT_EQ(exact[2].upper[0], 300);
  EXPECT_EQ(named(problem, "pyramid")[0].term->rows, 7);

  // A force on the cone's surface has distance 0 in both forms.
  Evaluation evaluation(problem);
  Trajectory t = problem.create_trajectory();
  Evaluator(problem).evaluate(t, evaluation);
  const auto same = named(problem, "same");
  const Eigen::Vector3d a = evaluation.constraint.segment(exact[0].row, 3);
  const Eigen::Vector3d b = evaluation.constraint.segment(same[0].row, 3);
  EXPECT_NEAR(a[2], 0.8 * b[2], 1e-9 * std::abs(b[2]));
  EXPECT_NEAR(a[0], b[0], 1e-9);
  EXPECT_NE(b[2], 0);
}

TEST(Constraints, CentersGiveOneConstraintEach) {
  const Loaded loaded(
      with("  posts: {residual: state, columns: [theta, omega], at_least: 0.5, knots: [2],\n"
           "          centers: [[3, 4], {from: [1, 0], to: [2, 6], count: 4}]}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  std::vector<NodeConstraint> posts;
  for (const NodeConstraint& c : named(problem, "posts"))
    if (c.node == 2) posts.push_back(c);
  ASSERT_EQ(posts.size(), 5u);
  Trajectory t = problem.create_trajectory();
  t.x(2) << 1, 1;
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(t, evaluation);
  const double expected[] = {std::hypot(2, 3), 1, std::hypot(1 / 3., 1), std::hypot(2 / 3., 3),
                             std::hypot(1, 5)};
  for (int i = 0; i < 5; ++i) {
    EXPECT_NEAR(evaluation.constraint[posts[i].row], expected[i], 1e-12);
    EXPECT_EQ(posts[i].lower[0], 0.5);
  }
}

TEST(Constraints, PosePositionsHaveColumns) {
  const Loaded loaded(R"(conddp: 1
system: {type: quadrotor}
initial_state: {values: {x: 1, y: 2, z: 3}}
phases: [{knots: 3, dt: 0.1}]
costs: {effort: {residual: control}}
constraints: {hall: {residual: state, columns: [z, x], upper: [5, 6]}}
solver: {name: altro}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(initial_values(*loaded.built->problem, "hall"), (std::vector<double>{3, 1}));
}

TEST(Constraints, ColumnsAreChosenByPatternsToo) {
  const Loaded loaded(R"(conddp: 1
system: {type: quadrotor}
initial_state: {values: {x: 1, y: 2, z: 3, vx: 4, vy: 5, vz: 6, wz: 7}}
phases: [{knots: 3, dt: 0.1}]
costs: {effort: {residual: control}}
constraints: {slow: {residual: state, columns: ["w*", vy, "v*", "*"], upper: 10}}
solver: {name: altro}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  // In the order of the patterns, without duplicates and without rotation entries.
  EXPECT_EQ(initial_values(*loaded.built->problem, "slow"),
            (std::vector<double>{0, 0, 7, 5, 4, 6, 1, 2, 3}));
}

TEST(Constraints, FindsContradictionsBeforeSolving) {
  const std::pair<std::string, const char*> cases[] = {
      {with("  speed: {bounds: velocity, lower: 2, upper: 1}\n"), "no value of 'omega' satisfies"},
      {with("  a: {residual: state, columns: theta, at_least: 2, at_most: 1}\n"),
       "no length is at least 2 and at most 1"},
      {with("  up: {residual: state, columns: theta, lower: 1}\n"),
       "the initial state violates the constraint 'up' by 0.9"},
      {with("  a: {bounds: state, upper: {theta: 1}}\n"
            "  b: {residual: state, columns: theta, reference: 2, equals: 0, knots: [3]}\n"),
       "'b' and 'a' contradict each other at knot 3"},
      {with("  a: {residual: control, equals: 4}\n"),
       "'a' and the bounds on the control contradict each other at knot 0"}};
  for (const auto& [text, message] : cases) {
    const Loaded loaded(text);
    EXPECT_FALSE(loaded.built) << message;
    EXPECT_NE(loaded.all().find(message), std::string::npos) << loaded.all();
  }
}

std::string expression(const std::string& name, const std::string& rest) {
  return "  " + name + ": {residual: expression, knots: [3], rows: " + rest + "}\n";
}

TEST(Constraints, ScaledRowsOfOneCoordinateContradict) {
  const std::string cases[] = {
      expression("a", "3*theta, upper: 2") + expression("b", "'-7*theta', upper: -5"),
      expression("a", "['theta/3.6 - 1', '2*theta + 2'], lower: [-1, 3.8], upper: [-0.76, 4]")};
  for (const std::string& rows : cases) {
    const Loaded loaded(with(rows));
    EXPECT_FALSE(loaded.built) << rows;
    EXPECT_NE(loaded.all().find("contradict each other"), std::string::npos) << loaded.all();
  }
}

TEST(Constraints, FindsNoContradictionIfValuesRemain) {
  const std::string cases[] = {
      expression("a", "3*theta, lower: -1, upper: 2") +
          expression("b", "theta, lower: 0.66, upper: 1"),
      expression("a", "2*theta - 2, equals: -1") + expression("b", "theta, equals: 0.5"),
      expression("a", "cos(theta), lower: 0.9") + expression("b", "theta, upper: 0.2"),
      expression("a", "1/(theta + 5), lower: 0.3") + expression("b", "theta, upper: 0.2"),
      // The branches of a conditional are parallel and do not meet.
      expression("a", "'if(theta < 1, theta, theta - 9)', upper: -5") +
          expression("b", "theta, lower: 2"),
      expression("a", "theta + omega, lower: 5") + expression("b", "theta, upper: 0.2")};
  for (const std::string& rows : cases) {
    const Loaded loaded(with(rows));
    EXPECT_EQ(loaded.all().find("contradict each other"), std::string::npos) << loaded.all();
  }
}

/// Controls bounded below by `lower` that change by at most 0.5 per knot.
std::string slow_controls(double lower, const std::string& initial) {
  return fmt::format(R"(conddp: 1
system: {{states: {{x: m}}, controls: {{u: m/s}}, rate: {{x: u}}}}
initial_state: {{values: {{x: 7}}{}}}
phases: [{{knots: 3, dt: 0.1}}]
costs: {{effort: {{residual: control}}}}
constraints:
  motor: {{bounds: control, lower: {}}}
  slow: {{residual: expression, rows: ["2*(u - previous[u]) + x - 7"], lower: -1, upper: 1}}
solver: {{name: altro}}
)",
                     initial, lower);
}

TEST(Constraints, FirstControlIsConsistentWithThePrevious) {
  for (const char* initial : {"", ", previous_control: 0"}) {
    const Loaded loaded(slow_controls(2, initial));
    EXPECT_FALSE(loaded.built);
    EXPECT_NE(loaded.all().find("'slow' and the bounds on the control contradict each other at "
                                "knot 0: nothing is at least 4 and at most 1"),
              std::string::npos)
        << loaded.all();
    EXPECT_NE(loaded.all().find("'previous_control' of the initial state"), std::string::npos)
        << loaded.all();
  }
  for (const std::string& file :
       {slow_controls(2, ", previous_control: 1.6"), slow_controls(0.5, "")}) {
    const Loaded loaded(file);
    EXPECT_TRUE(loaded.built) << loaded.all();
  }
}

TEST(Constraints, CountTowardsMemory) {
  EXPECT_GT(memory_need(100, 4, 2, 1, {.constraints = 1, .rows = 2}), memory_need(100, 4, 2, 1));
  const Loaded loaded(replaced(with("  posts: {residual: state, columns: theta, at_least: 0.1,\n"
                                    "          centers: [{from: [5], to: [9], count: 10000}]}\n"),
                               "knots: 4", "knots: 900000"));
  EXPECT_FALSE(loaded.built);
  EXPECT_NE(loaded.all().find("GiB of memory"), std::string::npos) << loaded.all();
}

TEST(Constraints, RejectsUnsupportedConstraints) {
  const std::pair<std::string, const char*> cases[] = {
      {with("  a: {residual: state, equals: 0, lower: 1}\n"), "lower"},
      {with("  a: {residual: state, columns: theta, cone: second_order}\n"),
       "a cone needs a residual of two rows or more"},
      {with("  a: {residual: state, cone: pyramid}\n"), "has no such cone"},
      {with("  a: {residual: state, slope: 2}\n"), "'slope' needs 'cone'"},
      {with("  a: {upper: 1}\n"), "lacks the key 'residual' or 'bounds'"},
      {with("  a: {bounds: velocity, from: urdf}\n"), "has no URDF"},
      {with("  a: {bounds: velocity}\n"), "need 'lower', 'upper' or 'from: urdf'"},
      {with("", "    a: {bounds: state, lower: 1}\n"), "bounds stand among the constraints"},
      {with("", "    a: {residual: control}\n"), "there is none at the terminal node"},
      {with("  a: {residual: state, columns: theta, centers: [[1]]}\n"),
       "a constraint from centers needs 'at_least' or 'at_most'"},
      {with("  a: {residual: state, columns: theta, at_least: 1, centers: []}\n"),
       "there is no center"},
      {with("  a: {residual: state, columns: theta, at_least: 1, centers: [[9], [1, 2]]}\n"),
       "a center has 1 number here, not 2"},
      {with("  a: {residual: state, columns: theta, at_least: 1, centers: [{from: [1], to: [2, 3], "
            "count: 3}]}\n"),
       "as many as 'from' has"},
      {with("  a: {residual: state, at_least: 1, centers: [[1, 2]]}\n"),
       "needs a residual that is a point"},
      {with("  a: {residual: state, columns: theta, reference: 3, at_least: 1, centers: [[9]]}\n"),
       "centers"},
      {with("  a: {residual: state, knots: [12]}\n"), "running knots are numbered from 0 to 9"}};
  for (const auto& [text, message] : cases) {
    const Loaded loaded(text);
    EXPECT_FALSE(loaded.built) << message;
    EXPECT_NE(loaded.all().find(message), std::string::npos) << message << "\n" << loaded.all();
  }
}

TEST(Constraints, UnsupportedConstraintsNameSolversAndHowToDrop) {
  Loaded loaded(replaced(with("  speed: {bounds: velocity, upper: 5}\n",
                              "    goal: {residual: state, reference: [1, 0]}\n"),
                         "altro", "box_ddp"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_TRUE(usable_solvers(*loaded.built, loaded.diagnostics).empty());
  const std::string text = loaded.all();
  EXPECT_NE(text.find("box_ddp does not support the constraint 'speed'"), std::string::npos)
      << text;
  EXPECT_NE(text.find("supported by altro, proxddp, ipddp, ipopt"), std::string::npos) << text;
  EXPECT_NE(text.find("--drop speed --drop goal"), std::string::npos) << text;
}

TEST(Constraints, DroppedConstraintsStillReportTheirViolation) {
  const Loaded loaded(with("  speed: {bounds: velocity, upper: 5}\n",
                           "    goal: {residual: state, reference: [1, 0]}\n"),
                      {}, {.drop = {"goal", "speed"}});
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_TRUE(problem.constraints().empty());
  ASSERT_EQ(loaded.built->dropped.size(), 2u);
  Trajectory t = problem.create_trajectory();
  t.x(3)[1] = 7;
  t.x(problem.knots()) << 1.5, 0;
  for (const DroppedConstraint& dropped : loaded.built->dropped)
    EXPECT_EQ(violation(dropped, problem, t), dropped.name == "speed" ? 2 : 0.5) << dropped.name;
}

/// Nodes at which a constraint holds.
std::vector<int> nodes_of(const ShootingProblem& problem, const std::string& name) {
  std::vector<int> nodes;
  for (const NodeConstraint& c : named(problem, name)) nodes.push_back(c.node);
  return nodes;
}

TEST(NodesOfConstraints, IncludeKnotStartsAndPhaseEnds) {
  for (const auto& [phases, nodes, expected] :
       {std::tuple{"first", "begins", std::vector{1, 2, 3}},
        std::tuple{"first", "ends", std::vector{1, 2, 3, 4}},
        std::tuple{"second", "ends", std::vector{4, 5, 6, 7, 8, 9, 10}},
        std::tuple{"[first, second]", "ends", std::vector{1, 2, 3, 4, 5, 6, 7, 8, 9, 10}}})
    for (const char* what : {"residual: state, columns: omega", "bounds: velocity"}) {
      const Loaded loaded(with(fmt::format(
          "  fast: {{{}, lower: -2, upper: 2, phases: {}, nodes: {}}}\n", what, phases, nodes)));
      ASSERT_TRUE(loaded.built) << loaded.all();
      EXPECT_EQ(nodes_of(*loaded.built->problem, "fast"), expected) << phases << nodes << what;
    }
}

TEST(NodesOfConstraints, EndsBelongToThePhaseBefore) {
  // The last phase has different states, and the jump between is instantaneous.
  const std::string text = R"(conddp: 1
systems:
  slide: {states: {x: m, v: m/s}, controls: {a: m/s^2}, rate: {x: v, v: a}}
  wait: {states: {x: m}, controls: {w: m/s}, rate: {x: w}}
initial_state: {values: {x: 1}}
phases:
  - {name: slide, system: slide, knots: 3, duration: 1}
  - {name: hit, jump: {v: -v}}
  - {name: back, system: slide, knots: 3, duration: 1}
  - {name: wait, system: wait, knots: 2, duration: 1}
constraints: {wall: {residual: expression, rows: x, upper: 2, phases: [slide, back], nodes: ends}}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(nodes_of(*loaded.built->problem, "wall"), (std::vector{1, 2, 3, 4, 5, 6, 7}));
  const Loaded expanded(expand_problem(*loaded.built).dump());
  ASSERT_TRUE(expanded.built) << expanded.all();
  EXPECT_EQ(nodes_of(*expanded.built->problem, "wall"), (std::vector{1, 2, 3, 4, 5, 6, 7}));
}

TEST(NodesOfConstraints, EndsHaveNoControl) {
  const Loaded force(with("  f: {residual: control, upper: 2, phases: first, nodes: ends}\n"));
  EXPECT_NE(force.all().find("'f' needs a control"), std::string::npos) << force.all();
  const Loaded bounds(with("  f: {bounds: control, upper: 2, nodes: ends}\n"));
  EXPECT_NE(bounds.all().find("controls of a phase do not last"), std::string::npos);
  const Loaded both(with("  f: {residual: state, upper: 2, knots: [2], nodes: ends}\n"));
  EXPECT_NE(both.all().find("'knots' and 'nodes' exclude"), std::string::npos) << both.all();
}

TEST(SoftConstraints, AreCostsOrHaveLimits) {
  const Loaded loaded(
      with("  speed: {bounds: velocity, lower: -2, upper: 5, soft: l1, weight: 3}\n"
           "  near: {residual: state, columns: theta, at_most: 1, soft: l2, weight: 7}\n",
           "    rest: {residual: state, columns: omega, soft: l1, weight: 4}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const auto speed = named(problem, "speed");
  ASSERT_EQ(speed.size(), 10u);
  EXPECT_DOUBLE_EQ(speed[0].limit, 3 * 0.1);
  EXPECT_DOUBLE_EQ(speed[8].limit, 3 * 0.05);
  EXPECT_DOUBLE_EQ(speed[9].limit, 3) << "nothing is a rate at the last node";
  EXPECT_DOUBLE_EQ(named(problem, "rest")[0].limit, 4);
  EXPECT_TRUE(named(problem, "near").empty());
  EXPECT_EQ(problem.soft_constraints().size(), 10u + 9u + 1u);

  Trajectory t = problem.create_trajectory();
  t.x(2) << 3, 8;
  const double expected = 0.1 * 0.5 * 7 * (3 - 1) * (3 - 1);
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(t, evaluation);
  const double effort = 0;
  EXPECT_NEAR(evaluation.cost[2], effort + expected, 1e-7);
  double near = 0, fast = 0;
  for (const auto& [name, value] : cost_by_name(problem, NodeValues(problem, t))) {
    if (name == "near") near = value;
    if (name == "speed") fast = value;
  }
  EXPECT_NEAR(near, expected, 1e-7);
  EXPECT_DOUBLE_EQ(fast, 0.1 * 3 * (8 - 5));
  const auto misses = soft_violations(problem, t, evaluation.constraint);
  ASSERT_EQ(misses.size(), 4u) << "two at running knots, two at the last node";
  EXPECT_EQ(misses[0].name, "speed");
  EXPECT_DOUBLE_EQ(misses[0].value, 3);
  EXPECT_EQ(misses[0].node, 2);
}

TEST(SoftConstraints, OnControlsAreNotSolverBounds) {
  const Loaded loaded(replaced(kPendulum, "{bounds: control, lower: -3, upper: 3}",
                               "{bounds: control, lower: -3, upper: 3, soft: l2, weight: 10}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_FALSE(problem.has_control_bounds());
  EXPECT_EQ(problem.soft_constraints().size(), 10u);
  EXPECT_FALSE(unsupported(*find_solver("fddp"), problem));
  Trajectory t = problem.create_trajectory();
  t.u(1)[0] = -5;
  Evaluation evaluation(problem);
  Evaluator(problem).evaluate(t, evaluation);
  EXPECT_NEAR(evaluation.cost[1], 0.1 * (0.5 * 0.5 * 25 + 0.5 * 10 * 4), 1e-12);
}

TEST(SoftConstraints, InitialStateConstraintIsAllowed) {
  const Loaded loaded(
      with("  fast: {residual: state, columns: omega, equals: 9, soft: l1, weight: 1}\n"));
  EXPECT_TRUE(loaded.built) << loaded.all();
}

}  // namespace
}  // namespace conddp
