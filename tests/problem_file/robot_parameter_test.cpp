// Payload masses as free parameters.
#include <cmath>

#include "analysis/derivatives/derivative_check.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A platform of 0.1 kg on a vertical rail.
constexpr std::string_view kLiftUrdf = R"(<robot name="lift">
  <link name="ground"/>
  <joint name="rail" type="prismatic">
    <parent link="ground"/><child link="platform"/><axis xyz="0 0 1"/>
    <limit lower="-10" upper="10" effort="100" velocity="100"/>
  </joint>
  <link name="platform">
    <inertial><mass value="0.1"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial>
  </link>
</robot>
)";

/// Moving a mass m by 1 in 1 s from rest to rest costs ∫ u² dt + 1/m with u = m (6 − 12 t), that is
/// 12 m² + 1/m.
constexpr std::string_view kLift = R"(conddp: 1
parameters: {load: {free: true, lower: 0, upper: 2, start: 1}}
robot:
  urdf: LIFT
  payloads: {platform: {mass: =load}}
gravity: [0, 0, 0]
initial_state: {}
integrator: rk4
phases: [{choose: none}, {name: up, knots: 100, duration: 1}]
costs: {effort: {residual: control, weight: 2}}
terminal:
  costs: {light: {residual: expression, rows: [1/(0.1 + load)], activation: linear}}
  constraints: {there: {residual: state, reference: {joints: {rail: 1}}}}
solver: {name: ipopt}
)";

/// An arm that carries a load to a pose; unknown properties of the load are free.
constexpr std::string_view kCarryingArm = R"(conddp: 1
parameters: {load: {free: true, lower: 2, upper: 2, start: 2}}
robot:
  urdf: robots/arm7.urdf
  payloads: {link_7: {mass: =load, com: [0.02, 0, 0.1], inertia: {ixx: 0.01, iyy: 0.02, izz: 0.02}}}
  configurations: {ready: {joints: {joint_2: 0.4, joint_4: -1.2, joint_6: 1.54}}}
initial_state: {configuration: ready}
phases: [{name: start, choose: none}, {name: reach, knots: 20, dt: 0.02}]
costs:
  posture: {residual: state, reference: ready, weights: {"v/*": 0.1}}
  effort: {residual: control_gravity, weight: 1.0e-3}
  center: {residual: com_position, reference: [0.1, 0, 0.5]}
constraints: {torque: {bounds: control, from: urdf}, limits: {bounds: state, from: urdf}}
terminal:
  costs:
    tool: {residual: frame_position, frame: tool, reference: [0.35, 0.45, 0.4], weight: 1.0e+3}
    rest: {residual: joint_velocity, weight: 10}
initial_guess: {states: initial, controls: quasi_static}
solver: {name: altro}
)";

/// A quadruped that stands, jumps, and lands with a load in its trunk.
constexpr std::string_view kCarryingQuadruped = R"(conddp: 1
parameters: {load: {free: true, lower: 3, upper: 3, start: 3}}
robot:
  urdf: robots/quadruped.urdf
  base: floating
  payloads: {trunk: {mass: =load, com: [0.1, 0.02, 0.15]}}
  configurations:
    standing:
      base: {position: [0, 0, 0.57]}
      joints:
        {LF_HAA: -0.2, LF_HFE: 0.75, LF_KFE: -1.5, RF_HAA: -0.2, RF_HFE: 0.75, RF_KFE: -1.5,
         LH_HAA: -0.2, LH_HFE: -0.75, LH_KFE: 1.5, RH_HAA: -0.2, RH_HFE: -0.75, RH_KFE: 1.5}
contacts:
  defaults: {friction: 0.7, min_normal_force: 5, baumgarte: {kd: 50}}
  LF: {frame: lf_foot}
  RF: {frame: rf_foot}
  LH: {frame: lh_foot}
  RH: {frame: rh_foot}
initial_state: {configuration: standing}
phases:
  - {name: start, choose: none}
  - {name: push, knots: 10, dt: 0.02, contacts: all}
  - {name: flight, knots: 5, dt: 0.02}
  - {name: landing, impulse: all}
  - {name: stand, knots: 10, dt: 0.02, contacts: [LF, RH]}
costs:
  posture: {residual: state, reference: standing, weights: {"base/*": 10, "v/*": 0.01}}
  effort: {residual: control, weight: 1.0e-3}
  force: {residual: contact_force, contacts: all, phases: [push, stand], weight: 1.0e-4}
  cone: {residual: friction_cone, contacts: all, phases: [push, stand], safety: 0.85, weight: 10}
  momentum: {residual: centroidal_momentum, weight: 0.1}
  center: {residual: com_position, reference: [0, 0, 0.55]}
  hold: {residual: control_gravity, phases: flight, weight: 1.0e-3}
  slow: {residual: joint_acceleration, weight: 1.0e-6}
  light: {residual: expression, rows: ["load*v[LF_HAA]", c.x*load], of: {c: {residual: com_position}}}
initial_guess: {states: initial, controls: quasi_static}
solver: {name: box_fddp}
)";

std::string lift_text(const TemporaryFolder& folder, std::string_view text) {
  return replaced(text, "LIFT", folder.write("lift.urdf", std::string(kLiftUrdf)));
}

SolveResult answer_by(const Loaded& loaded, const char* solver) {
  return solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
}

int state_column(const Loaded& loaded, const std::string& name) {
  for (std::size_t i = 0; i < loaded.built->state_columns.size(); ++i)
    if (loaded.built->state_columns[i].name == name) return static_cast<int>(i);
  ADD_FAILURE() << "no column " << name;
  return 0;
}

/// The same problem with a number in place of the free parameter.
std::string with_number(std::string_view text, const std::string& number) {
  std::string fixed(text);
  const std::size_t begin = fixed.find("parameters: {load"), end = fixed.find('\n', begin);
  fixed.replace(begin, end - begin, "parameters: {load: " + number + "}");
  return fixed;
}

/// The text without the choosing knot.
std::string without_choice(const std::string& text, const std::string& entry) {
  return replaced(text, entry, "");
}

void expect_right_derivatives(const Loaded& loaded) {
  ASSERT_TRUE(loaded.built) << loaded.all();
  const auto compared =
      check_derivatives(*loaded.built->problem, loaded.built->guess, {.knots_per_phase = 3});
  EXPECT_FALSE(compared.empty());
  for (const DerivativeComparison& derivative : compared)
    EXPECT_LT(derivative.error, kDerivativeTolerance)
        << "phase " << derivative.phase << " term " << derivative.term << " row " << derivative.row
        << " column " << derivative.column;
}

TEST(RobotParameters, HaveTheLoadOfMinimumCost) {
  const TemporaryFolder folder;
  const Loaded loaded(lift_text(folder, kLift));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const double m = 1 / std::cbrt(24.0);
  for (const char* solver : {"ipopt", "altro", "proxddp"}) {
    const SolveResult result = answer_by(loaded, solver);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(result.cost, 12 * m * m + 1 / m, 1e-4 * result.cost) << solver;
    for (int k = 1; k <= result.trajectory.knots(); ++k) {
      EXPECT_NEAR(result.trajectory.x(k)[state_column(loaded, "load")], m - 0.1, 1e-4) << solver;
      EXPECT_NEAR(result.trajectory.x(k)[state_column(loaded, "load_rate")], 0, 1e-12) << solver;
    }
  }
}

/// 20 N hold 20/9.81 kg, including 0.1 kg for the platform.
TEST(RobotParameters, FindTheLargestLoadOfAMotor) {
  const TemporaryFolder folder;
  std::string text = replaced(lift_text(folder, kLift), "gravity: [0, 0, 0]\n", "");
  text = replaced(text, "upper: 2, start: 1", "upper: 10, start: 0.5");
  text = replaced(text, "weight: 2}}\n",
                  "weight: 1.0e-9}}\nconstraints:\n"
                  "  motor: {bounds: control, lower: -20, upper: 20}\n");
  text = replaced(text, "reference: {joints: {rail: 1}}", "reference: initial");
  text = replaced(text, "rows: [1/(0.1 + load)]", "rows: [-load]");
  text = replaced(text, "knots: 100, duration: 1", "knots: 5, duration: 1");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const char* solver : {"ipopt", "altro"}) {
    const SolveResult result = answer_by(loaded, solver);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(result.trajectory.x(3)[state_column(loaded, "load")], 20 / 9.81 - 0.1, 1e-5)
        << solver;
  }
}

TEST(RobotParameters, HaveCorrectDerivatives) {
  const std::string free_arm = replaced(kCarryingArm, "lower: 2, upper: 2", "lower: 0, upper: 5");
  expect_right_derivatives(Loaded(free_arm));
  expect_right_derivatives(Loaded(replaced(free_arm, "costs:\n", "integrator: rk4\ncosts:\n")));
  expect_right_derivatives(
      Loaded(replaced(kCarryingQuadruped, "lower: 3, upper: 3", "lower: 0, upper: 5")));
}

/// Cost of the simulated motion of its controls.
double simulated_cost(const Loaded& loaded) {
  const ShootingProblem& problem = *loaded.built->problem;
  Trajectory motion = loaded.built->guess;
  Evaluator evaluator(problem);
  EXPECT_EQ(evaluator.simulate(motion), -1);
  Evaluation evaluation(problem);
  evaluator.evaluate(motion, evaluation);
  return evaluation.cost.sum();
}

/// Compares guesses that hold the robot, and the motions they lead to.
void expect_equal_motions(const Loaded& free, const Loaded& fixed, double tolerance) {
  ASSERT_TRUE(free.built) << free.all();
  ASSERT_TRUE(fixed.built) << fixed.all();
  const Trajectory& a = free.built->guess;
  const Trajectory& b = fixed.built->guess;
  ASSERT_EQ(a.knots(), b.knots() + 1);
  for (int k = 0; k < b.knots(); ++k)
    for (Eigen::Index i = 0; i < b.u(k).size(); ++i)
      EXPECT_NEAR(a.u(k + 1)[i], b.u(k)[i], tolerance) << "guess of knot " << k;
  const double cost = simulated_cost(fixed);
  EXPECT_NEAR(simulated_cost(free), cost, tolerance * (1 + cost));
}

TEST(RobotParameters, EqualBoundsMatchANumber) {
  const Loaded free_arm{std::string(kCarryingArm)},
      arm(without_choice(with_number(kCarryingArm, "2"), "{name: start, choose: none}, "));
  expect_equal_motions(free_arm, arm, 1e-9);
  const Loaded free_quadruped{std::string(kCarryingQuadruped)},
      quadruped(without_choice(with_number(kCarryingQuadruped, "3"),
                               "  - {name: start, choose: none}\n"));
  expect_equal_motions(free_quadruped, quadruped, 1e-9);
  const SolveResult free = answer_by(free_quadruped, "box_fddp");
  const SolveResult fixed = answer_by(quadruped, "box_fddp");
  EXPECT_EQ(free.status, SolveStatus::converged);
  EXPECT_EQ(fixed.status, SolveStatus::converged);
  EXPECT_NEAR(free.cost, fixed.cost, 1e-9 * fixed.cost);
}

/// Torques that move an arm with 3 kg, and the resulting states, identify the 3 kg.
TEST(RobotParameters, AreIdentifiedFromARecordedMotion) {
  const TemporaryFolder folder;
  const Loaded plant(
      without_choice(with_number(kCarryingArm, "3"), "{name: start, choose: none}, "));
  ASSERT_TRUE(plant.built) << plant.all();
  const ShootingProblem& problem = *plant.built->problem;
  Trajectory motion = plant.built->guess;
  std::string table = "t";
  for (const Column& column : plant.built->state_columns) table += "," + column.name;
  for (const Column& column : plant.built->control_columns) table += "," + column.name;
  for (int k = 0; k < motion.knots(); ++k)
    for (int i = 0; i < problem.nu(k); ++i) motion.u(k)[i] += 2 * std::sin(0.3 * k + i);
  ASSERT_EQ(Evaluator(problem).simulate(motion), -1);
  for (int k = 0; k <= motion.knots(); ++k) {
    table += fmt::format("\n{}", problem.times()[k]);
    for (const double x : motion.x(k)) table += fmt::format(",{}", x);
    for (const double u : motion.u(std::min(k, motion.knots() - 1))) table += fmt::format(",{}", u);
  }
  const std::string file = folder.write("motion.csv", table + '\n');
  std::string text =
      replaced(kCarryingArm, "lower: 2, upper: 2, start: 2", "lower: 0, upper: 20, start: 1");
  text.replace(text.find("costs:"), text.find("solver:") - text.find("costs:"),
               "costs:\n  states: {residual: state, reference: {file: " + file +
                   "}, weight: 100}\n  torques: {residual: control, reference: {file: " + file +
                   "}}\nterminal: {costs: {end: {residual: state, reference: {file: " + file +
                   "}}}}\n");
  const Loaded identified(text);
  ASSERT_TRUE(identified.built) << identified.all();
  for (const char* solver : {"box_fddp", "ipopt"}) {
    const SolveResult result = answer_by(identified, solver);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(result.trajectory.x(1)[state_column(identified, "load")], 3, 1e-6) << solver;
    EXPECT_NEAR(result.cost, 0, 1e-9) << solver;
  }
}

TEST(RobotParameters, SeveralRobotsShareThem) {
  const TemporaryFolder folder;
  const std::string urdf = folder.write("lift.urdf", std::string(kLiftUrdf));
  const Loaded loaded(fmt::format(R"(conddp: 1
parameters: {{load: {{free: true, lower: 0, upper: 2}}}}
robots:
  a: {{urdf: {0}, payloads: {{platform: {{mass: =load}}}}}}
  b: {{urdf: {0}, payloads: {{platform: {{mass: =load}}}}}}
gravity: [0, 0, 0]
initial_state: {{}}
integrator: rk4
phases: [{{choose: none}}, {{name: up, knots: 100, duration: 1}}]
costs: {{effort: {{residual: control, weight: 2}}}}
terminal:
  costs: {{light: {{residual: expression, rows: [2/(0.1 + load)], activation: linear}}}}
  constraints: {{there: {{residual: joint_position, reference: 1}}, rest: {{residual: joint_velocity}}}}
solver: {{name: altro}}
)",
                                  urdf));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->ndx(), 6);
  const SolveResult result = answer_by(loaded, "altro");
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_NEAR(result.trajectory.x(1)[state_column(loaded, "load")], 1 / std::cbrt(24.0) - 0.1,
              1e-4);
}

// Nothing moves a parameter, so it is no part of the regulator's state.
TEST(RobotParameters, RegulatorsLeaveThemOut) {
  const TemporaryFolder folder;
  const std::string text = replaced(replaced(lift_text(folder, kLift), "costs: {effort",
                                             "costs: {still: {residual: state}, effort"),
                                    "terminal:\n", "terminal:\n  lqr: initial\n");
  const Loaded free(text);
  std::string number = replaced(text, "{free: true, lower: 0, upper: 2, start: 1}", "1");
  number = replaced(number, "{choose: none}, ", "");
  number = replaced(number, "residual: expression, rows: [1/(0.1 + load)]", "residual: state");
  const Loaded fixed(number);
  ASSERT_TRUE(free.built) << free.all();
  ASSERT_TRUE(fixed.built) << fixed.all();
  const Eigen::MatrixXd& P = free.built->terminal_lqr->ingredients.P;
  const Eigen::MatrixXd& Q = fixed.built->terminal_lqr->ingredients.P;
  ASSERT_EQ(P.rows(), 4);
  const int rail = state_column(free, "q/rail"), speed = state_column(free, "v/rail");
  const std::vector<int> own = {rail, speed};
  EXPECT_NEAR((P(own, own) - Q).norm(), 0, 1e-9 * Q.norm());
  EXPECT_NEAR(P.norm(), Q.norm(), 1e-9 * Q.norm()) << "all other entries are zero";
  const Loaded heavy(replaced(text, "gravity: [0, 0, 0]", "gravity: [0, 0, -9.81]"));
  EXPECT_NE(heavy.all().find("the equilibrium depends on 'load', which no control moves"),
            std::string::npos)
      << heavy.all();
}

/// A block on the ground that carries a load.
constexpr std::string_view kLoadedBlock = R"(conddp: 1
parameters: {load: {free: true, lower: 2, upper: 2}}
robot:
  urdf: robots/block.urdf
  actuation: {joints: [base_x]}
  payloads: {body: {mass: =load, com: [0.1, 0, 0.1]}}
initial_state: {joints: {base_z: 0.5}}
contact_candidates:
  rear: {frame: corner_1, friction: 0.5}
  front: {frame: corner_2, friction: 0.5}
stepping: {plane: [0, 1, 0]}
phases: [{knots: 4, dt: 0.05}]
costs: {effort: {residual: control}}
solver: {name: ipopt}
)";

// The same numbers by name leave the same residuals of the steps, but for the row of the load.
TEST(RobotParameters, ContactImplicitStepsCarryThem) {
  const Loaded free{std::string(kLoadedBlock)};
  const Loaded fixed(replaced(kLoadedBlock, "{free: true, lower: 2, upper: 2}", "2"));
  ASSERT_TRUE(free.built) << free.all();
  ASSERT_TRUE(fixed.built) << fixed.all();
  const ShootingProblem &p = *free.built->problem, &q = *fixed.built->problem;
  Trajectory a = free.built->guess, b = fixed.built->guess;
  const auto& states = fixed.built->state_columns;
  const auto& own = p.knot(1).model->system().control_columns();
  const auto& others = q.knot(0).model->system().control_columns();
  for (int k = 0; k < q.knots(); ++k) {
    for (std::size_t i = 0; i < states.size(); ++i)
      a.x(k + 1)[state_column(free, states[i].name)] = b.x(k)[i] += 0.01 * (i + k);
    for (std::size_t i = 0; i < others.size(); ++i) {
      const auto at = std::ranges::find(own, others[i].name, &Column::name) - own.begin();
      a.u(k + 1)[at] = b.u(k)[i] = 0.1 * std::sin(1.0 + i + k);
    }
  }
  Evaluation with(p), without(q);
  Evaluator(p).evaluate(a, with);
  Evaluator(q).evaluate(b, without);
  const int load = fixed.built->plant.robot().nv;
  for (int k = 0; k < q.knots(); ++k) {
    const auto at = [](const ShootingProblem& problem, int node) {
      return *std::ranges::find(problem.constraints(), node, &NodeConstraint::node);
    };
    const NodeConstraint c = at(p, k + 1), d = at(q, k);
    ASSERT_EQ(c.term->rows, d.term->rows + 1);
    for (int i = 0; i < d.term->rows; ++i)
      EXPECT_NEAR(with.constraint[c.row + i + (i < load ? 0 : 1)], without.constraint[d.row + i],
                  1e-12)
          << k << " " << i;
  }
  for (const DerivativeComparison& c : check_derivatives(p, a))
    EXPECT_LT(c.error, kDerivativeTolerance) << c.knot << " " << c.row << " " << c.column;
}

TEST(RobotParameters, MayAppearOnlyInExpressions) {
  const TemporaryFolder folder;
  // The target is free: ½ p² + 12 (1 − p)² has its minimum at p = 24/25.
  std::string text =
      replaced(lift_text(folder, kLift), "load: {free: true, lower: 0, upper: 2, start: 1}",
               "load: 0.9, p: {free: true, lower: -5, upper: 5}");
  text = replaced(text, "light: {residual: expression, rows: [1/(0.1 + load)], activation: linear}",
                  "small: {residual: expression, rows: [p]}");
  text = replaced(text, "there: {residual: state, reference: {joints: {rail: 1}}}",
                  "there: {residual: expression, rows: \"q[rail] + p - 1\"}, "
                  "rest: {residual: joint_velocity}");
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(answer_by(loaded, "altro").trajectory.x(1)[state_column(loaded, "p")], 0.96, 1e-4);
}

TEST(RobotParameters, AreReadAgainFromTheExpandedFile) {
  const TemporaryFolder folder;
  for (const char* choice : {"choose: none", "choose: all", "choose: v/rail"}) {
    const Loaded loaded(replaced(lift_text(folder, kLift), "choose: none", choice));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const std::string text = expanded_text(*loaded.built);
    EXPECT_NE(text.find("mass: load"), std::string::npos) << text;
    const Loaded again(text);
    ASSERT_TRUE(again.built) << again.all();
    EXPECT_EQ(again.built->problem->nu(0), loaded.built->problem->nu(0));
    EXPECT_EQ(answer_by(again, "altro").cost, answer_by(loaded, "altro").cost);
  }
}

TEST(RobotParameters, AreExcludedFromListsOfTheState) {
  const TemporaryFolder folder;
  const std::string text = lift_text(folder, kLift);
  const Loaded without(replaced(text, "initial_state: {}", "initial_state: {state: [0.5, 0]}"));
  ASSERT_TRUE(without.built) << without.all();
  EXPECT_EQ(without.built->problem->initial_state(), (std::vector<double>{0.5, 1, 0, 0}));
  const Loaded wrong(replaced(text, "initial_state: {}", "initial_state: {state: [0.5]}"));
  EXPECT_NE(wrong.all().find("the state has 2 numbers, not 1"), std::string::npos) << wrong.all();
}

TEST(RobotParameters, HaveTheirPlaceInErrors) {
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {{"lower: 0,", "lower: -1,", "2:14: error: the mass 'load' may be -1 kg"},
                        {"mass: =load", "mass: =2*load",
                         "5:31: error: this depends on a free parameter, which the solver chooses"},
                        {"mass: =load", "mass: 1, com: [0, 0, =load]",
                         "5:46: error: this depends on a free parameter, which the solver chooses"},
                        {"mass: =load", "mass: =lode", "5:32: error: "},
                        {"mass: =load", "mass: lode", "5:31: error: "},
                        {"  payloads", "  parameters: {load: 1}\n  payloads",
                         "5:16: error: 'load' is free, and stands here again"},
                        {"  payloads: {platform: {mass: =load}}",
                         "  parameters: {q: 1}\n  payloads: {platform: {mass: 1}}",
                         "5:16: error: the robot has a name 'q' already"},
                        {"  payloads: {platform: {mass: =load}}",
                         "  parameters: {rail: 1}\n  payloads: {platform: {mass: 1}}",
                         "5:16: error: the robot has a name 'rail' already"},
                        {"  payloads: {platform: {mass: =load}}",
                         "  parameters: {l: -1}\n  payloads: {platform: {mass: l}}",
                         "6:31: error: the mass 'l' starts at -1 kg"},
                        {"costs: {effort: {residual: control",
                         "costs: {effort: {residual: joint_position, joints: load",
                         "'load' is a parameter, not a joint"}};
  const TemporaryFolder folder;
  for (const Case& c : cases) {
    const Loaded loaded(replaced(lift_text(folder, kLift), c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_NE(loaded.all().find(c.message), std::string::npos) << c.message << '\n' << loaded.all();
  }
}

}  // namespace
}  // namespace conddp
