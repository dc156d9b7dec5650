// Terminal costs and sets of the linear-quadratic regulator in problem files.
#include <cmath>

#include "analysis/terminal/terminal_set.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/motion/quasi_static.hpp"
#include "schema_document.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/robots.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// The exact double integrator over 0.1 s with Q = I and R = 0.1 as rates.
std::string exact_integrator(int knots, std::string_view lqr = "initial",
                             std::string_view more = "") {
  return fmt::format(R"(conddp: 1
system: {{type: linear, A: [[1, 0.1], [0, 1]], B: [[0.005], [0.1]]}}
initial_state: {{state: [1, 0]}}
phases: [{{name: only, knots: {}, dt: 0.1}}]
costs:
  state: {{residual: state}}
  effort: {{residual: control, weight: 0.1}}
terminal: {{lqr: {}}}
solver: {{name: box_fddp, tolerances: {{stationarity: 1.0e-10}}}}
{})",
                     knots, lqr, more);
}

constexpr std::string_view kUnitForce =
    "constraints: {force: {bounds: control, lower: -1, upper: 1}}\n";

std::string balanced_cartpole(std::string_view about) {
  return fmt::format(R"(conddp: 1
system: {{type: cartpole}}
initial_state: {{values: {{theta: 3.141592653589793}}}}
integrator: semi_implicit_euler
phases: [{{name: only, knots: 10, dt: 0.02}}]
costs:
  state: {{residual: state, reference: {{values: {{theta: 3.141592653589793}}}}, weights: [1, 10, 0.1, 0.1]}}
  effort: {{residual: control, weight: 0.1}}
constraints: {{force: {{bounds: control, lower: -5, upper: 5}}}}
terminal: {{lqr: {}}}
)",
                     about);
}

const TerminalLqr& lqr_of(const Loaded& loaded) { return *loaded.built->terminal_lqr; }

double optimal_cost(const Loaded& loaded) {
  const SolverInfo& solver = *find_solver(loaded.spec->solver.name.value);
  const SolveResult result =
      solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
  EXPECT_EQ(result.status, SolveStatus::converged);
  return result.cost;
}

/// Cost of the regulator from x̄ ⊕ T y under the nonlinear map, without the cost's value and slope
/// at the equilibrium.
double cost_of_closed_loop(const TerminalIngredients& own, const Eigen::VectorXd& y, int steps) {
  const KnotModel& model = *own.knot->knot(0).model;
  const KnotView& knot = own.knot->knot(0);
  KnotWorkspace<double> work(model);
  std::vector<double> x(own.x.size());
  const Eigen::VectorXd start = own.tangent * y;
  model.manifold().integrate(own.x.data(), start.data(), x.data());
  double sum = 0;
  for (int k = 0; k < steps; ++k) {
    Eigen::VectorXd z(model.nz());
    model.manifold().difference(own.x.data(), x.data(), z.data());
    z.tail(model.nu()) = -(own.K * z.head(model.ndx()));
    const Eigen::VectorXd u = own.u + z.tail(model.nu());
    model.evaluate(KnotInput<double>{x.data(), u.data(), knot.parameters, knot.dt, knot.cost_scale},
                   work);
    sum += work.cost - own.cost - own.gradient.dot(z);
    std::copy(work.next().begin(), work.next().end(), x.begin());
  }
  return sum;
}

/// Checks that ½ δᵀPδ is the regulator's cost near the equilibrium in several directions. Averaging
/// both signs cancels the third derivatives.
void expect_cost_to_go(const TerminalIngredients& own, double size, double tolerance) {
  const int m = static_cast<int>(own.tangent.cols());
  for (int i = 0; i < m; i += 1 + m / 4) {
    Eigen::VectorXd y = Eigen::VectorXd::Constant(m, 0.3 * size);
    y[i] = -size;
    const double expected = 0.5 * y.dot(own.regulator.P * y);
    const double mean =
        0.5 * (cost_of_closed_loop(own, y, 4000) + cost_of_closed_loop(own, -y, 4000));
    EXPECT_NEAR(mean, expected, tolerance * expected) << i;
  }
}

// The numbers of this and the next four tests were computed from the definitions by other programs,
// those of the cart-pole with 50 digits.
TEST(TerminalLqr, ExactDoubleIntegratorHasKnownIngredients) {
  const Loaded loaded(exact_integrator(10, "[0, 0]", kUnitForce));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  EXPECT_NEAR(own.P(0, 0), 1.3317224441130, 1e-12);
  EXPECT_NEAR(own.P(0, 1), 0.3201562118716, 1e-12);
  EXPECT_NEAR(own.P(1, 1), 0.4603514023781, 1e-12);
  EXPECT_NEAR(own.K(0, 0), 2.5857008966598, 1e-12);
  EXPECT_NEAR(own.K(0, 1), 3.4434359178453, 1e-12);
  EXPECT_NEAR(lqr_of(loaded).set.level, 0.0387749825794, 1e-12);
}

TEST(TerminalLqr, SemiImplicitEulerHasADifferentRegulator) {
  const Loaded loaded(R"(conddp: 1
system: {type: double_integrator, dimension: 1}
initial_state: {}
phases: [{knots: 5, dt: 0.1}]
costs: {state: {residual: state}, effort: {residual: control, weight: 0.1}}
terminal: {lqr: initial}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  EXPECT_NEAR(own.P(0, 0), 1.2827049330091, 1e-12);
  EXPECT_NEAR(own.K(0, 0), 2.5853072593251, 1e-12);
  EXPECT_NEAR(own.K(0, 1), 3.3161863748807, 1e-12);
  EXPECT_TRUE(std::isinf(lqr_of(loaded).set.level));
}

TEST(TerminalLqr, FiniteHorizonsCostTheInfiniteValue) {
  for (const int knots : {1, 2, 7}) {
    const Loaded loaded(exact_integrator(knots, "[0, 0]"));
    ASSERT_TRUE(loaded.built) << loaded.all();
    EXPECT_NEAR(optimal_cost(loaded), 0.6658612220565547, 1e-12) << knots;
  }
}

TEST(TerminalLqr, BoundedHorizonsHaveTheirKnownCosts) {
  for (const auto& [knots, cost] : {std::pair{1, 0.6846654702972},
                                    {2, 0.6959507781838},
                                    {3, 0.7012943894519},
                                    {4, 0.7027180645701},
                                    {5, 0.7027180807405},
                                    {10, 0.7027180807405}}) {
    const Loaded loaded(exact_integrator(knots, "[0, 0]", kUnitForce));
    ASSERT_TRUE(loaded.built) << loaded.all();
    EXPECT_NEAR(optimal_cost(loaded), cost, 1e-10) << knots;
  }
}

TEST(TerminalLqr, UprightCartpoleHasKnownIngredients) {
  const Loaded loaded(balanced_cartpole("initial"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  const double K[] = {-2.782295471473159, 38.18477246260595, -3.941708742685367, 7.617934144892557};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(own.K(0, i), K[i], 1e-10);
  const double modulus[] = {.978833, .978833, .898866, .898866};
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(std::abs(own.regulator.eigenvalues[i]), modulus[i], 1e-6);
  EXPECT_NEAR(lqr_of(loaded).set.level, 0.2232324342955199, 1e-12);
  expect_cost_to_go(own, 1e-4, 1e-5);
}

TEST(TerminalLqr, ConditionsHoldOnTheLinearSystemSet) {
  const Loaded loaded(exact_integrator(10, "[0, 0]", kUnitForce));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalConditions found = check_terminal_conditions(
      lqr_of(loaded).ingredients, {.level = lqr_of(loaded).set.level, .tolerance = 1e-9});
  EXPECT_TRUE(found.hold());
  EXPECT_NEAR(found.conditions[3].figure, 1, 1e-9);
  EXPECT_LE(found.conditions[2].figure, 1);
  const TerminalConditions beyond = check_terminal_conditions(
      lqr_of(loaded).ingredients, {.level = 4 * lqr_of(loaded).set.level, .tolerance = 1e-9});
  EXPECT_FALSE(beyond.conditions[1].holds);
  EXPECT_GT(beyond.conditions[1].figure, 0.1);
  EXPECT_NEAR(beyond.conditions[1].level, lqr_of(loaded).set.level, 1e-12);
}

/// Two states with a cost on the first only, and a bounded control.
std::string half_seen(std::string_view x, std::string_view y, double weight,
                      std::string_view more = "") {
  return fmt::format(R"(conddp: 1
system: {{states: [x, y], controls: [u], next: {{x: {}, y: {}}}}}
initial_state: {{values: {{x: 1}}}}
phases: [{{knots: 20, dt: 1}}]
costs: {{u: {{residual: control}}, s: {{residual: expression, rows: [x], weight: {}}}}}
constraints: {{b: {{bounds: control, lower: -1, upper: 1}}{}}}
terminal: {{lqr: {{about: {{values: {{x: 0}}}}, set: true}}}}
)",
                     x, y, weight, more);
}

TEST(TerminalLqr, DecayingCostlessStatesLeaveZeroRows) {
  struct Case {
    const char *x, *y;
    double weight;
  };
  for (const Case& c : {Case{"1.069*x+u", "-0.942*x+0.449*y+5.065*u", 496.32},
                        {"0.954*x+u", "0.695*x+0.812*y+3.785*u", 495.94},
                        {"0.909*x+u", "0.675*x+0.673*y+6.496*u", 186.72},
                        {"1.189*x+u", "-0.542*x+0.933*y+8.31*u", 31.56}}) {
    SCOPED_TRACE(c.x);
    const Loaded loaded(half_seen(c.x, c.y, c.weight));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const TerminalIngredients& own = lqr_of(loaded).ingredients;
    EXPECT_TRUE(own.P.row(1).isZero(0) && own.P.col(1).isZero(0));
    const double level = lqr_of(loaded).set.level;
    EXPECT_NEAR(level, own.P(0, 0) / (own.K(0, 0) * own.K(0, 0)), 1e-10 * level);
    const TerminalConditions found =
        check_terminal_conditions(own, {.level = level, .tolerance = 1e-9});
    EXPECT_TRUE(found.hold());
    EXPECT_NEAR(found.conditions[3].figure, 1, 1e-9);
  }
}

TEST(TerminalLqr, ConditionsHoldWithACostlessDirectionAcrossStates) {
  const Loaded loaded(R"(conddp: 1
system: {states: [x, y], controls: [u], next: {x: 0.8509901428700724*x+0.2956349189965381*y+0.7648421872844885*u, y: 0.2956349189965381*x+0.7490098571299277*y+0.644217687237691*u}}
initial_state: {values: {x: 1}}
phases: [{knots: 20, dt: 1}]
costs: {u: {residual: control}, s: {residual: expression, rows: [0.7648421872844885*x+0.644217687237691*y]}}
constraints: {b: {residual: control, lower: -1, upper: 1}}
terminal: {lqr: {about: {values: {x: 0}}, set: true}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalConditions found = check_terminal_conditions(
      lqr_of(loaded).ingredients, {.level = lqr_of(loaded).set.level, .tolerance = 1e-9});
  EXPECT_TRUE(found.hold());
  EXPECT_NEAR(found.conditions[3].figure, 1, 1e-9);
}

TEST(TerminalLqr, BoundedCostlessStatesHaveNoSet) {
  EXPECT_EQ(Loaded(half_seen("0.909*x+u", "0.675*x+0.673*y+6.496*u", 186.72,
                             ", y: {residual: state, columns: [y], lower: -1, upper: 1}"))
                .first_error(),
            "7:48: no terminal set is within 'y', which states that cost nothing move");
}

std::string bounded_speed(std::string_view bounds, std::string_view about, std::string_view start) {
  return fmt::format(R"(conddp: 1
system: {{states: [x, v], controls: [u], rate: {{x: v, v: u}}}}
initial_state: {{values: {{x: {}}}}}
phases: [{{knots: 40, dt: 0.05}}]
costs: {{u: {{residual: control}}, s: {{residual: state}}}}
constraints: {{b: {{bounds: control, lower: -5, upper: 5}}, speed: {{residual: state, {}}}}}
terminal: {{lqr: {{about: {{values: {{x: {}}}}}}}}}
)",
                     start, bounds, about);
}

TEST(TerminalLqr, NormsBoundTheSetAroundTheirCenter) {
  const auto level = [](std::string_view bounds, std::string_view about = "0",
                        std::string_view start = "1") {
    const Loaded loaded(bounded_speed(bounds, about, start));
    EXPECT_TRUE(loaded.built) << loaded.all();
    return loaded.built ? lqr_of(loaded).set.level : 0;
  };
  const double box = level("columns: [v], lower: -0.3, upper: 0.3");
  EXPECT_NEAR(box, 0.1069720717, 1e-9);
  EXPECT_NEAR(level("columns: [v], at_most: 0.3"), box, 1e-9 * box);
  const double wall = level("columns: [x], lower: 1", "2");
  EXPECT_NEAR(level("columns: [x], at_least: 1", "2"), wall, 1e-7 * wall);
  EXPECT_NEAR(level("columns: [x], at_least: 1, at_most: 9", "2"), wall, 1e-7 * wall);
  EXPECT_EQ(level("columns: [x], at_least: 1"), 0);
  // The circle lies within its square.
  const double square = level("lower: -0.3, upper: 0.3", "0", "0"),
               circle = level("at_most: 0.3", "0", "0");
  EXPECT_GT(circle, 0.4 * square);
  EXPECT_LT(circle, square);
}

TEST(TerminalLqr, ChecksNothingWithoutCosts) {
  const Loaded loaded(R"(conddp: 1
system: {states: [x, y], controls: [u], next: {x: 0.5*x, y: 0.5*y}}
initial_state: {values: {x: 1}}
phases: [{knots: 20, dt: 1}]
costs: {u: {residual: control}}
constraints: {b: {bounds: control, lower: -1, upper: 1}}
terminal: {lqr: {values: {x: 0}}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalConditions found =
      check_terminal_conditions(lqr_of(loaded).ingredients, {.level = lqr_of(loaded).set.level});
  EXPECT_EQ(found.samples, 0);
  EXPECT_TRUE(found.conditions.empty());
}

std::string pushed_and_pulled(std::string_view rate, std::string_view about, double upper = 1) {
  return fmt::format(R"(conddp: 1
system: {{states: [x, v], controls: [a, b], rate: {{x: v, v: {}}}}}
initial_state: {{values: {{x: 1}}}}
phases: [{{knots: 20, dt: 0.05}}]
costs: {{u: {{residual: control}}, s: {{residual: state}}}}
constraints: {{b: {{bounds: control, lower: 0, upper: {}}}}}
terminal: {{lqr: {{values: {{x: {}}}}}}}
)",
                     rate, upper, about);
}

TEST(TerminalLqr, BoundedControlHoldsTheStateBeyondMinimumNorm) {
  const Loaded loaded(pushed_and_pulled("a - b - 0.1*x", "0.1"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  EXPECT_NEAR(own.u[0], 0.01, 1e-12);
  EXPECT_EQ(own.u[1], 0);
  EXPECT_LT(own.drift, 1e-9);
}

TEST(TerminalLqr, ControlAtItsBoundHoldsTheState) {
  // In floating point, 9.81 / (1/3) is not 29.43.
  const Loaded loaded(pushed_and_pulled("a/3 + b/3 - 9.81", "0", 14.715));
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const double u : lqr_of(loaded).ingredients.u) EXPECT_NEAR(u, 14.715, 1e-9);
  for (const double upper : {2.9, 29.43}) {
    const Loaded lone(fmt::format(R"(conddp: 1
system: {{states: [x, v], controls: [u], rate: {{x: v, v: u/3 - 9.81}}}}
initial_state: {{values: {{x: 1}}}}
phases: [{{knots: 20, dt: 0.05}}]
costs: {{u: {{residual: control}}, s: {{residual: state}}}}
constraints: {{b: {{bounds: control, lower: 0, upper: {}}}}}
terminal: {{lqr: {{values: {{x: 0}}}}}}
)",
                                  upper));
    EXPECT_EQ(lone.built.has_value(), upper > 3) << lone.all();
    if (!lone.built) continue;
    EXPECT_LE(lqr_of(lone).ingredients.u[0], upper);
  }
}

TEST(TerminalLqr, EquilibriumSetHasOnlyConstraintConditions) {
  const Loaded loaded(pushed_and_pulled("0.1*a - 0.3*b", "0"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(lqr_of(loaded).set.level, 0);
  const TerminalConditions found = check_terminal_conditions(lqr_of(loaded).ingredients, {});
  EXPECT_EQ(found.samples, 0);
  ASSERT_EQ(found.conditions.size(), 2u);
  EXPECT_TRUE(found.hold());
}

TEST(TerminalLqr, LargerWeightSufficesAtASmallerLevel) {
  const Loaded loaded(read_file(kProblems / "arm_reach.yaml"),
                      std::vector<std::string>{"terminal.lqr=initial"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalLqr& lqr = lqr_of(loaded);
  const TerminalConditions found =
      check_terminal_conditions(lqr.ingredients, {.level = lqr.set.level});
  EXPECT_LE(found.conditions[3].figure, 0);
  ASSERT_GT(found.decrease.level, 0);
  EXPECT_LT(found.decrease.level, found.level);
  EXPECT_GT(found.decrease.factor, 1);
  const TerminalConditions heavier = check_terminal_conditions(
      lqr.ingredients, {.weight = found.decrease.factor, .level = found.decrease.level});
  EXPECT_TRUE(heavier.conditions[3].holds) << heavier.conditions[3].figure;
}

TEST(TerminalLqr, LargerWeightMakesNonlinearTerminalCostDecrease) {
  const Loaded loaded(balanced_cartpole("initial"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalLqr& lqr = lqr_of(loaded);
  const auto decrease = [&](double weight) {
    return check_terminal_conditions(lqr.ingredients, {.weight = weight, .level = lqr.set.level})
        .conditions[3];
  };
  const TerminalCondition plain = decrease(1);
  EXPECT_FALSE(plain.holds);
  EXPECT_GT(plain.figure, 0.5);
  EXPECT_LT(plain.figure, 1);
  EXPECT_TRUE(decrease(1.001 / plain.figure).holds);
}

TEST(TerminalLqr, WeightMultipliesTheCostToGo) {
  const Loaded one(exact_integrator(1, "{about: [0, 0]}"));
  const Loaded two(exact_integrator(1, "{about: [0, 0], weight: 2}"));
  ASSERT_TRUE(one.built && two.built) << one.all() << two.all();
  const auto at_end = [](const Loaded& loaded) {
    const Phase& end = loaded.built->problem->terminal();
    KnotWorkspace<double> work(*end.model);
    const double x[2] = {1, 0};
    end.model->evaluate(KnotInput<double>{x, nullptr, end.parameters.data(), 0.0, 1.0}, work);
    return work.cost;
  };
  EXPECT_NEAR(at_end(one), 0.6658612220565547, 1e-12);
  EXPECT_NEAR(at_end(two), 2 * 0.6658612220565547, 1e-12);
}

TEST(TerminalLqr, SetAsAConstraintHoldsAndCosts) {
  const Loaded loaded(replaced(exact_integrator(18, "{about: [0, 0], set: true}", kUnitForce),
                               "box_fddp", "altro"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve(*loaded.built->problem, *find_solver("altro"),
                                   loaded.spec->solver.options, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged);
  const Eigen::VectorXd end = result.trajectory.x(18);
  const TerminalLqr& lqr = lqr_of(loaded);
  EXPECT_NEAR(end.dot(lqr.ingredients.P * end), lqr.set.level, 1e-5);
  EXPECT_GT(result.cost, 0.7027180807405);
}

TEST(TerminalLqr, RegulatesRotationsOnTheManifold) {
  const Loaded loaded(R"(conddp: 1
system: {type: quadrotor}
initial_state: {values: {z: 1}}
phases: [{knots: 10, dt: 0.02}]
costs:
  state: {residual: state, reference: {values: {z: 1}}}
  effort: {residual: control, weight: 0.1}
constraints: {thrust: {bounds: control, lower: 0, upper: 5}}
terminal: {lqr: {about: {values: {z: 1}}, set: true}}
solver: {name: altro}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  ASSERT_EQ(own.P.rows(), 12);
  for (int i = 0; i < 4; ++i) EXPECT_NEAR(own.u[i], own.u[0], 1e-10);
  EXPECT_GT(own.u[0], 0.1);
  EXPECT_LT(own.regulator.residual, 1e-10);
  EXPECT_LT(std::abs(own.regulator.eigenvalues[0]), 1);
  EXPECT_GT(lqr_of(loaded).set.level, 0);
  expect_cost_to_go(own, 1e-4, 1e-3);
}

TEST(TerminalLqr, RememberedControlIsPartOfTheState) {
  const Loaded loaded(R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.5}}
phases: [{knots: 5, dt: 0.05}]
costs:
  state: {residual: state, reference: initial}
  effort: {residual: control, weight: 0.01}
  rate: {residual: control_rate, weight: 0.1}
terminal: {lqr: initial}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  ASSERT_EQ(own.x.size(), 3u);
  EXPECT_NE(own.u[0], 0);
  EXPECT_EQ(own.x[2], own.u[0]);
  EXPECT_LT(own.drift, 1e-9);
  expect_cost_to_go(own, 1e-4, 1e-3);
}

/// A pendulum held off the vertical by a torque, with optional integrals of effort and rotation.
std::string held_pendulum(std::string_view integrals, std::string_view terminal,
                          std::string_view about = "{about: initial, set: true}") {
  return fmt::format(R"(conddp: 1
system: {{type: pendulum}}
initial_state: {{values: {{theta: 0.5}}}}
phases: [{{knots: 20, dt: 0.05}}]
{}costs:
  state: {{residual: state, reference: initial}}
  effort: {{residual: control, weight: 0.01}}
  rate: {{residual: control_rate, weight: 0.1}}
constraints:
  torque: {{bounds: control, lower: -9, upper: 9}}
terminal: {{lqr: {}{}}}
solver: {{name: altro, tolerances: {{stationarity: 1.0e-9}}}}
)",
                     integrals, about, terminal);
}

constexpr std::string_view kHeldIntegrals =
    "integrals: {work: torque^2, turned: {rows: \"1 + omega*omega\"}}\n";

TEST(TerminalLqr, RegulatorExcludesIntegrals) {
  const Loaded plain(held_pendulum("", "")), counting(held_pendulum(kHeldIntegrals, ""));
  ASSERT_TRUE(plain.built && counting.built) << plain.all() << counting.all();
  const TerminalIngredients &a = lqr_of(plain).ingredients, &b = lqr_of(counting).ingredients;
  const int own[] = {0, 1, 4};  // theta, omega, and the previous torque, with integrals in between
  ASSERT_EQ(b.P.rows(), 5);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(b.K(0, own[i]), a.K(0, i), 1e-10);
    for (int j = 0; j < 3; ++j) EXPECT_NEAR(b.P(own[i], own[j]), a.P(i, j), 1e-10);
  }
  EXPECT_TRUE(b.P.middleCols(2, 2).isZero(0) && b.P.middleRows(2, 2).isZero(0));
  EXPECT_TRUE(b.K.middleCols(2, 2).isZero(0));
  EXPECT_NEAR(lqr_of(counting).set.level, lqr_of(plain).set.level, 1e-10);
  EXPECT_EQ(b.x[2], 0);
  EXPECT_LT(b.drift, 1e-9);
  expect_cost_to_go(b, 1e-4, 1e-3);
  ConditionOptions options;
  options.level = 0.5 * lqr_of(counting).set.level;
  const TerminalConditions at_a = check_terminal_conditions(a, options);
  const TerminalConditions at_b = check_terminal_conditions(b, options);
  ASSERT_EQ(at_a.conditions.size(), at_b.conditions.size());
  for (std::size_t i = 0; i < at_a.conditions.size(); ++i)
    EXPECT_EQ(at_a.conditions[i].holds, at_b.conditions[i].holds) << at_a.conditions[i].name;
}

/// From the vertical to the regulated state. Integrals change nothing until an active budget limits
/// them.
TEST(TerminalLqr, BudgetsWorkWithTheRegulator) {
  const auto solved = [](const Loaded& loaded) {
    EXPECT_TRUE(loaded.built) << loaded.all();
    return solve(*loaded.built->problem, *find_solver("altro"), loaded.spec->solver.options,
                 loaded.built->guess);
  };
  const std::string about = "{about: {values: {theta: 0.5}}}";
  const auto at_rest = [&](std::string_view integrals, std::string_view terminal) {
    return Loaded(replaced(replaced(held_pendulum(integrals, terminal, about),
                                    "initial_state: {values: {theta: 0.5}}", "initial_state: {}"),
                           "reference: initial", "reference: {values: {theta: 0.5}}"));
  };
  const SolveResult plain = solved(at_rest("", "")), counting = solved(at_rest(kHeldIntegrals, ""));
  ASSERT_EQ(counting.status, SolveStatus::converged) << counting.message;
  EXPECT_NEAR(counting.cost, plain.cost, 1e-8 * plain.cost);
  const double spent = counting.trajectory.x(20)[2];
  double effort = 0;
  for (int k = 0; k < 20; ++k) effort += 0.05 * std::pow(counting.trajectory.u(k)[0], 2);
  EXPECT_NEAR(spent, effort, 1e-9);
  const SolveResult saving = solved(at_rest(
      kHeldIntegrals,
      fmt::format(", constraints: {{budget: {{residual: expression, rows: [work], upper: {}}}}}",
                  0.9 * spent)));
  ASSERT_EQ(saving.status, SolveStatus::converged) << saving.message;
  EXPECT_NEAR(saving.trajectory.x(20)[2], 0.9 * spent, 1e-5 * spent);
  EXPECT_GT(saving.cost, counting.cost);
}

TEST(TerminalLqr, NamesCostsAndSetsOnIntegrals) {
  const auto error = [](std::string_view terms) {
    return Loaded(replaced(held_pendulum(kHeldIntegrals, ""), "constraints:\n", terms))
        .first_error();
  };
  EXPECT_EQ(error("  spent: {residual: expression, rows: work*omega}\nconstraints:\n"),
            "13:25: the running cost 'spent' depends on 'work', which no regulator "
            "can control");
  EXPECT_EQ(error("constraints:\n  budget: {residual: expression, rows: [work], upper: 50}\n"),
            "13:39: no terminal set is within 'budget', which states that cost nothing move");
}

/// A standing robot, regulated on the tangent space of its contacts.
void expect_stance(const Loaded& loaded, int directions) {
  ASSERT_TRUE(loaded.built) << loaded.all();
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  EXPECT_EQ(own.tangent.cols(), directions);
  EXPECT_LT(std::abs(own.regulator.eigenvalues[0]), 1 - 1e-6);
  EXPECT_LT(own.regulator.residual, 1e-9);
  // Directions normal to the tangent space cost nothing.
  const Eigen::MatrixXd across =
      Eigen::MatrixXd::Identity(own.P.rows(), own.P.rows()) - own.tangent * own.tangent.transpose();
  EXPECT_LT((own.P * across).norm(), 1e-9 * own.P.norm());
  EXPECT_LT((own.K * across).norm(), 1e-9 * own.K.norm());
  // Legs that push against each other through the ground move nothing. The control is the one
  // closest to the guess, which already holds the state.
  const Eigen::VectorXd guess =
      quasi_static_control(own.knot->knot(0).model->system(), own.x.data());
  EXPECT_LT((own.u - guess).norm(), 1e-6 * guess.norm());
  expect_cost_to_go(own, 1e-5, 1e-3);
}

Loaded load_with(const std::filesystem::path& file, std::vector<std::string> settings) {
  return Loaded(read_file(file), settings);
}

TEST(TerminalLqr, RegulatesQuadrupedStanceOnContactTangentSpace) {
  expect_stance(load_with(kProblems / "quadruped_stand.yaml", {"terminal.lqr=standing"}), 12);
}

TEST(TerminalLqr, StandingQuadrupedSupportsIntegrals) {
  const std::string integral = "integrals={work: {rows: \"u[LF_KFE]^2 + v[LF_HFE]*u[LF_HFE]\"}}";
  const Loaded loaded =
      load_with(kProblems / "quadruped_stand.yaml", {"terminal.lqr=standing", integral});
  expect_stance(loaded, 12);
  const TerminalIngredients& own = lqr_of(loaded).ingredients;
  EXPECT_EQ(own.P.rows(), loaded.built->plant.system->ndx() + 1);
  EXPECT_TRUE(own.P.rightCols(1).isZero(0));
}

TEST(TerminalLqr, ForeignRobotsStandToo) {
  const auto hyq = foreign_robot_folder() / "hyq.urdf",
             anymal = foreign_robot_folder() / "anymal_b.urdf";
  if (!std::filesystem::exists(hyq) || !std::filesystem::exists(anymal))
    GTEST_SKIP() << kNoForeignRobots;
  const auto legs = source_tree() / "tests/golden/legs";
  for (const auto& [name, urdf] : {std::pair{"hyq", hyq}, {"anymal_b", anymal}}) {
    SCOPED_TRACE(name);
    expect_stance(load_with(legs / (std::string(name) + ".yaml"),
                            {"robot.urdf=" + urdf.string(), "terminal.lqr=initial",
                             "phases=[{name: stand, knots: 4, dt: 0.01, contacts: all}]",
                             "costs={posture: {residual: state, reference: standing}, "
                             "effort: {residual: control, weight: 0.001}}"}),
                  12);
  }
}

TEST(TerminalLqr, GuessesInterpolateToTheEquilibrium) {
  const Loaded loaded(exact_integrator(10, "[3, 0]", "initial_guess: {states: interpolate}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NEAR(loaded.built->guess.x(5)[0], 2, 1e-14);
  EXPECT_EQ(loaded.built->guess.x(10)[0], 3);
}

TEST(TerminalLqr, ExpansionIsEquivalent) {
  for (const char* lqr : {"initial", "[0, 0]", "{about: [0, 0], weight: 2}", "{values: {x/0: 0}}",
                          "{about: {values: {x/0: 0}}, set: true}"}) {
    const Loaded loaded(exact_integrator(3, lqr, kUnitForce));
    if (std::string(lqr) == "initial") {
      EXPECT_TRUE(loaded.built) << loaded.all();  // also rests at 1
    }
    ASSERT_TRUE(loaded.built) << lqr << loaded.all();
    const std::string text = expanded_text(*loaded.built);
    const Loaded again(text);
    ASSERT_TRUE(again.built) << again.all();
    EXPECT_EQ(expanded_text(*again.built), text);
    EXPECT_EQ(lqr_of(again).ingredients.P, lqr_of(loaded).ingredients.P);
    EXPECT_EQ(lqr_of(again).set.level, lqr_of(loaded).set.level);
  }
}

TEST(TerminalLqr, ReportsMistakesAtTheirPlaces) {
  const auto error = [](const std::string& text) { return Loaded(text).first_error(); };
  EXPECT_EQ(error(exact_integrator(3, "up")), "8:17: unknown state 'up'");
  EXPECT_EQ(error(exact_integrator(3, "[0, 0, 0]")), "8:17: the state has 2 numbers, not 3");
  EXPECT_EQ(error(exact_integrator(3, "[0, 1]")),
            "8:17: the state is not an equilibrium: with the control that holds it best, 'x/0' "
            "changes by 0.998 in a second");
  EXPECT_EQ(error(balanced_cartpole("{values: {theta: 1}}")).substr(0, 35),
            "10:17: the state is not an equilibr");
  EXPECT_EQ(error(exact_integrator(3, "{about: [0, 0], set: true}")),
            "8:38: nothing bounds the terminal set");
  EXPECT_EQ(error(exact_integrator(3, "{weight: 2}")),
            "8:17: 'terminal.lqr' lacks the key 'about'");
  EXPECT_EQ(error(replaced(exact_integrator(3, "[0, 0]"),
                           "  effort: {residual: control, weight: 0.1}\n", "")),
            "7:17: the running cost leaves a direction of the control free: the least eigenvalue "
            "of its scaled Hessian in the control is 0");
  EXPECT_EQ(
      error(replaced(exact_integrator(3, "[0, 0]"), "{residual: state}",
                     "{residual: state, weights: [0, 1]}")),
      "8:17: the running cost does not depend on the mode with eigenvalue 1 of 'x/0', which does "
      "not decay");
  EXPECT_EQ(
      error(replaced(exact_integrator(3, "[0, 0]"), "B: [[0.005], [0.1]]", "B: [[0.1], [0]]")),
      "8:17: no control moves the mode with eigenvalue 1 of 'x/1', which does not decay");
  EXPECT_EQ(error(replaced(exact_integrator(3, "[0, 0]"), "terminal: {",
                           "terminal: {costs: {lqr: {residual: state}}, ")),
            "8:20: this name is that of what 'terminal: {lqr: ...}' adds");
  EXPECT_EQ(error(replaced(exact_integrator(3, "[0, 0]"), "  state: {", "  lqr: {")),
            "6:3: this name is that of what 'terminal: {lqr: ...}' adds");
  EXPECT_EQ(error(replaced(exact_integrator(3, "{about: [0, 0], set: true}", kUnitForce),
                           "force: {bounds", "lqr: {bounds")),
            "10:15: this name is that of what 'terminal: {lqr: ...}' adds");
}

TEST(TerminalLqr, NamesStatesWithNonFiniteDynamics) {
  EXPECT_EQ(Loaded(R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u + log(x)}}
initial_state: {values: {x: 1}}
phases: [{knots: 20, dt: 0.05}]
costs: {u: {residual: control}, x: {residual: state}}
terminal: {lqr: {values: {x: 0}}}
)")
                .first_error(),
            "6:17: the system is not finite at this state, or its derivatives are not");
}

TEST(TerminalLqr, UnreachableControlHoldsNothing) {
  EXPECT_EQ(Loaded(replaced(kPendulum, "terminal:\n",
                            "terminal:\n  lqr: {values: {theta: 1.5707963267948966}}\n"),
                   {"constraints.torque.upper=1"})
                .first_error(),
            "14:8: the control that holds the state exceeds its bounds: 'torque' is 4.905, and may "
            "be -3 to 1");
}

// The regulator takes steps as the file writes them; P is zero along the duration.
TEST(TerminalLqr, FreeDurationKeepsTheRegulator) {
  const auto P_of = [](const std::string& phases) {
    const Loaded loaded(
        "conddp: 1\nsystem: {type: double_integrator, dimension: 1}\n"
        "initial_state: {}\nphases: [" +
        phases + R"(]
costs: {state: {residual: state}, effort: {residual: control, weight: 0.1}}
terminal: {lqr: initial}
)");
    EXPECT_TRUE(loaded.built) << loaded.all();
    return loaded.built ? loaded.built->terminal_lqr->ingredients.P : Eigen::MatrixXd();
  };
  const Eigen::MatrixXd fixed = P_of("{knots: 5, dt: 0.1}");
  const Eigen::MatrixXd free =
      P_of("{choose: none}, {knots: 5, dt: 0.1, free_duration: {lower: 0.1, upper: 2}}");
  ASSERT_EQ(free.rows(), 3);
  EXPECT_LT((free.topLeftCorner<2, 2>() - fixed).norm(), 1e-12);
  EXPECT_TRUE(free.row(2).isZero(0) && free.col(2).isZero(0));
}

TEST(TerminalLqr, CollocationIsUnsupported) {
  EXPECT_EQ(Loaded(R"(conddp: 1
system: {type: double_integrator, dimension: 1}
initial_state: {}
integrator: trapezoidal
phases: [{knots: 5, dt: 0.1}]
costs: {state: {residual: state}, effort: {residual: control, weight: 0.1}}
terminal: {lqr: initial}
)")
                .first_error(),
            "7:17: 'lqr' needs steps that are maps of state and control, and these have unknowns "
            "of their own");
}

}  // namespace
}  // namespace conddp
