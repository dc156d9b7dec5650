// Controls linear between knots.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "analysis/certificate/replay.hpp"
#include "analysis/comparison/random_instance.hpp"
#include "analysis/derivatives/derivative_check.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/temporary_folder.hpp"

namespace conddp {
namespace {

/// A mass moves one meter from rest to rest with minimum energy ∫u², integrated by a state. rk4 is
/// exact for linear controls, and the optimum u = 6 − 12 t is linear.
const std::string kLeastEnergy = R"(conddp: 1
system:
  states: {x: m, v: m/s, energy: "1"}
  controls: {force: N}
  rate: {x: v, v: force, energy: force^2}
initial_state: {values: {x: 0}}
integrator: rk4
controls: linear
phases:
  - {name: start, choose: none}
  - {name: move, knots: 4, duration: 1}
terminal:
  costs:
    energy: {residual: expression, rows: [energy], activation: linear}
  constraints:
    there: {residual: state, columns: [x, v], reference: {values: {x: 1}}}
solver: {name: ipopt}
)";

/// A pendulum with active bounds and costs on state and control.
const std::string kSwing = R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.4}}
integrator: rk4
controls: linear
phases:
  - {name: start, choose: none}
  - {name: first, knots: 8, dt: 0.05}
  - {name: second, knots: 6, dt: 0.1}
costs:
  effort: {residual: control, weight: 0.1}
  way: {residual: state, weight: 0.2, phases: first}
constraints:
  torque: {bounds: control, lower: -2, upper: 3}
terminal:
  costs:
    goal: {residual: state, reference: {values: {theta: 1}}, weight: 20}
solver: {name: ipopt}
)";

/// The swing with half the step length.
std::string halved(const std::string& swing) {
  return replaced(replaced(swing, "knots: 8, dt: 0.05", "knots: 16, dt: 0.025"),
                  "knots: 6, dt: 0.1", "knots: 12, dt: 0.05");
}

SolveResult solved(const Loaded& loaded, const std::string& solver) {
  EXPECT_TRUE(loaded.built) << loaded.all();
  SolverOptions options = loaded.spec->solver.options;
  options.max_iterations = 500;
  return solve(*loaded.built->problem, solver, options, loaded.built->guess);
}

/// The control at each node from the first after the choice.
std::vector<double> nodal_controls(const Trajectory& trajectory) {
  std::vector<double> controls;
  for (int k = 1; k <= trajectory.knots(); ++k)
    controls.push_back(trajectory.x(k)[trajectory.nx() - 1]);
  return controls;
}

TEST(LinearControls, ReachTheExactOptimumIfLinear) {
  for (const char* integrator : {"rk4", "hermite_simpson", "radau5"}) {
    const Loaded loaded(replaced(kLeastEnergy, "rk4", integrator));
    const SolveResult result = solved(loaded, "ipopt");
    ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
    EXPECT_NEAR(result.cost, 12, 1e-8) << integrator;
    const std::vector<double> u = nodal_controls(result.trajectory);
    for (int k = 0; k <= 4; ++k) EXPECT_NEAR(u[k], 6 - 3 * k, 1e-6) << integrator;
  }
}

TEST(LinearControls, ConvergeWithTheSquareOfTheStep) {
  // The optimum of ∫u² + x² from x = 1 with x' = u is tanh 1.
  const std::string text = R"(conddp: 1
system: {states: {x: m}, controls: {u: m/s}, rate: {x: u}}
initial_state: {values: {x: 1}}
controls: linear
phases:
  - {name: start, choose: none}
  - {name: move, knots: 10, duration: 1}
costs:
  both: {residual: expression, rows: [x, u], weight: 2}
solver: {name: ilqr}
)";
  const auto error = [&](const std::string& knots) {
    const SolveResult result =
        solved(Loaded(replaced(text, "knots: 10", "knots: " + knots)), "ilqr");
    EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
    return std::abs(result.cost - std::tanh(1));
  };
  EXPECT_NEAR(std::log2(error("10") / error("20")), 2, 0.1);
  EXPECT_NEAR(std::log2(error("20") / error("40")), 2, 0.1);
}

TEST(LinearControls, HaveOneOptimumForAllSolvers) {
  const Loaded loaded(kSwing);
  const SolveResult known = solved(loaded, "ipopt");
  ASSERT_EQ(known.status, SolveStatus::converged) << known.message;
  for (const char* solver : {"box_ddp", "box_fddp", "altro", "proxddp"}) {
    const SolveResult result = solved(loaded, solver);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_NEAR(result.cost, known.cost, 1e-6 * known.cost) << solver;
  }
  const Loaded unbounded(
      replaced(kSwing, "constraints:\n  torque: {bounds: control, lower: -2, upper: 3}\n", ""));
  const double least = solved(unbounded, "ipopt").cost;
  EXPECT_LT(least, known.cost * (1 - 1e-4));
  for (const char* solver : {"ilqr", "ddp", "fddp"})
    EXPECT_NEAR(solved(unbounded, solver).cost, least, 1e-6 * least) << solver;
}

TEST(LinearControls, KeepTheirBoundsEverywhere) {
  const Loaded loaded(kSwing);
  const SolveResult result = solved(loaded, "box_ddp");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const std::vector<double> u = nodal_controls(result.trajectory);
  EXPECT_EQ(*std::max_element(u.begin(), u.end()), 3);
  EXPECT_GE(*std::min_element(u.begin(), u.end()), -2);
}

TEST(LinearControls, DerivativesMatchDualNumbers) {
  const std::string curved = replaced(
      kSwing, "constraints:\n",
      "constraints:\n  power: {residual: expression, rows: [\"torque*omega\"], upper: [4]}\n");
  for (const std::string& text : {kLeastEnergy, kSwing, curved}) {
    const Loaded loaded(text);
    ASSERT_TRUE(loaded.built) << loaded.all();
    Trajectory point = loaded.built->guess;
    for (int k = 0; k <= point.knots(); ++k) {
      for (int i = 0; i < point.nx(); ++i) point.x(k)[i] += std::sin(1 + 2 * k + 5 * i);
      if (k < point.knots())
        for (int i = 0; i < point.nu(k); ++i) point.u(k)[i] += std::cos(3 * k + i);
    }
    for (const DerivativeComparison& c : check_derivatives(*loaded.built->problem, point))
      EXPECT_LT(c.error, 1e-8) << c.phase << " " << c.row << " " << c.column << text;
  }
}

TEST(LinearControls, ArePassedOnWithFreeDurations) {
  // Time-optimal with limited force: linear controls approach 2 from above.
  const std::string text =
      replaced(replaced(kLeastEnergy, "duration: 1}",
                        "duration: 2, free_duration: {lower: 0.5, upper: 5}}"),
               "  costs:\n    energy: {residual: expression, rows: [energy], activation: linear}\n",
               "") +
      "costs: {time: {residual: combination, rows: {constant: 1}, weight: 2}}\n"
      "constraints: {force: {bounds: control, lower: -1, upper: 1}}\n";
  const auto duration = [&](const std::string& knots) {
    const Loaded loaded(replaced(text, "knots: 4", "knots: " + knots));
    const SolveResult result = solved(loaded, "ipopt");
    EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
    const std::vector<double> u = nodal_controls(result.trajectory);
    EXPECT_NEAR(u.front(), 1, 1e-6);
    EXPECT_NEAR(u.back(), -1, 1e-6);
    return loaded.built->problem->times(result.trajectory).back();
  };
  // With n knots, the force is −1 or 1 except on the middle knot, where it ramps from 1 to −1. For
  // a ramp of length T/n, T²/4 (1 − 1/(3 n²)) = 1.
  for (const int n : {5, 15})
    EXPECT_NEAR(duration(std::to_string(n)), 2 / std::sqrt(1 - 1 / (3.0 * n * n)), 1e-5) << n;
}

/// A mass moves one meter in phases with free or given durations; TERMS are its costs and
/// constraints.
constexpr std::string_view kLinearPhases = R"(conddp: 1
system: {states: {x: m, v: m/s}, controls: {u: N}, rate: {x: v, v: u - 0.2*v*v}}
initial_state: {values: {x: 0, v: 0}}
integrator: rk4
controls: linear
phases:
  - {name: start, choose: none}
  - {name: first, knots: 6, FIRST}
  - {name: second, knots: 8, SECOND}
costs:
  time: {residual: expression, rows: 1 + 0.1*x, activation: linear, weight: 2}
  effort: {residual: control, weight: 0.3}
  early: {residual: expression, rows: [u - v], weight: 0.1, phases: first}
TERMS
terminal: {constraints: {there: {residual: expression, rows: [x - 1, v]}}}
solver: {name: altro, tolerances: {stationarity: 1.0e-8}}
)";

constexpr std::string_view kChosenDuration = "duration: 1, free_duration: {lower: 0.3, upper: 4}";

std::string linear_phases(std::string_view terms, std::string_view first, std::string_view second) {
  return replaced(replaced(replaced(kLinearPhases, "TERMS", terms), "FIRST", first), "SECOND",
                  second);
}

/// Trapezoids by hand with the chosen durations.
TEST(LinearControls, PhaseEndCostsGrowWithOwnDurations) {
  constexpr std::string_view terms = R"(
  lasting: {residual: expression, rows: u*x, activation: linear, weight: 0.7, phases: second}
constraints:
  gentle: {residual: expression, rows: [u], upper: [1.2], soft: l1, weight: 1.5, phases: first}
  slow: {residual: expression, rows: [u - x], upper: [1], soft: l2, weight: 3})";
  const auto chosen = [](bool free, std::string_view given) {
    return free ? kChosenDuration : given;
  };
  for (const auto& [first, second] : {std::pair(true, true), {true, false}, {false, true}}) {
    SCOPED_TRACE(fmt::format("{} {}", first, second));
    const double durations[] = {first ? 2.5 : 1.3, second ? 1.2 : 0.7};
    const Loaded loaded(linear_phases(terms.substr(1), chosen(first, "duration: 1.3"),
                                      chosen(second, "duration: 0.7")));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const ShootingProblem& problem = *loaded.built->problem;
    Trajectory t = loaded.built->guess;
    int number = 0;
    if (first) t.u(0)[number++] = durations[0];
    if (second) t.u(0)[number++] = durations[1];
    t.u(0)[number] = 0.5;
    for (int k = 1; k < t.knots(); ++k) t.u(k)[0] = 0.5 + 0.25 * k;
    ASSERT_EQ(Evaluator(problem).simulate(t), -1);
    double time = 0, effort = 0, early = 0, lasting = 0, gentle = 0, slow = 0;
    for (int k = 1; k < t.knots(); ++k) {
      const bool in_first = k <= 6;
      const double half = 0.5 * (in_first ? durations[0] / 6 : durations[1] / 8);
      for (const int node : {k, k + 1}) {
        const double x = t.x(node)[0], v = t.x(node)[1], u = 0.5 + 0.25 * (node - 1);
        time += half * 2 * (1 + 0.1 * x);
        effort += half * 0.3 * 0.5 * u * u;
        slow += half * 3 * 0.5 * std::pow(std::max(u - x - 1, 0.0), 2);
        if (in_first) early += half * 0.1 * 0.5 * (u - v) * (u - v);
        if (in_first) gentle += half * 1.5 * std::max(u - 1.2, 0.0);
        if (!in_first) lasting += half * 0.7 * u * x;
      }
    }
    const auto sums = cost_by_name(problem, NodeValues(problem, t));
    const auto sum = [&](const std::string& name) {
      double all = 0;
      for (const auto& [own, cost] : sums)
        if (own == name || own == "terminal/" + name) all += cost;
      return all;
    };
    EXPECT_NEAR(sum("time"), time, 1e-12);
    EXPECT_NEAR(sum("effort"), effort, 1e-12);
    EXPECT_NEAR(sum("early"), early, 1e-12);
    EXPECT_NEAR(sum("lasting"), lasting, 1e-12);
    EXPECT_NEAR(sum("gentle"), gentle, 1e-12);
    EXPECT_NEAR(sum("slow"), slow, 1e-12);
    EXPECT_GT(gentle, 0);
    for (const DerivativeComparison& c : check_derivatives(problem, t))
      EXPECT_LT(c.error, kDerivativeTolerance) << c.knot << " " << c.row << " " << c.column;
  }
}

/// From 0 to 1 by x' = u with a running cost in u only: the optimal u is constant, all rules are
/// exact, and u minimizes the cost per meter. For 2 + ½ u², the cost is 2 at u = 2. With an
/// additional ½ per unit beyond 1.5, it is u + ½ at u² = 2.5. With 3/2 of its square instead, it is
/// 4 u − 4.5 at u² = 2.6875.
TEST(LinearControls, FreeDurationsHaveTheOptimumOfTheirCosts) {
  struct Case {
    const char* soft;
    double speed, cost;
  };
  const Case cases[] = {{"", 2, 2},
                        {"l1, weight: 0.5", std::sqrt(2.5), std::sqrt(2.5) + 0.5},
                        {"l2, weight: 3", std::sqrt(2.6875), 4 * std::sqrt(2.6875) - 4.5}};
  constexpr const char* free = "duration: 0.3, free_duration: {lower: 0.01, upper: 5}";
  for (const Case& c : cases)
    for (const auto& [first, second] :
         {std::pair(free, "duration: 0.2"), {"duration: 0.2", free}}) {
      const Loaded loaded(fmt::format(
          R"(conddp: 1
system: {{states: {{x: m}}, controls: {{u: m/s}}, rate: {{x: u}}}}
initial_state: {{values: {{x: 0}}}}
controls: linear
phases: [{{choose: none}}, {{knots: 3, {}}}, {{knots: 2, {}}}]
costs:
  time: {{residual: combination, rows: {{constant: 1}}, weight: 4}}
  effort: {{residual: control}}
{}terminal: {{constraints: {{there: {{residual: expression, rows: [x - 1]}}}}}}
solver: {{name: altro, tolerances: {{stationarity: 1.0e-9, constraint: 1.0e-9}}}}
)",
          first, second,
          *c.soft ? fmt::format("constraints: {{limit: {{residual: control, upper: 1.5, "
                                "soft: {}}}}}\n",
                                c.soft)
                  : ""));
      ASSERT_TRUE(loaded.built) << loaded.all();
      for (const char* solver : {"altro", "proxddp", "ipopt"}) {
        SCOPED_TRACE(fmt::format("{} {} {}", c.soft, first, solver));
        const SolveResult result = solved(loaded, solver);
        ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
        EXPECT_NEAR(result.cost, c.cost, 1e-6);
        for (const double u : nodal_controls(result.trajectory)) EXPECT_NEAR(u, c.speed, 1e-4);
        EXPECT_NEAR(loaded.built->problem->times(result.trajectory).back(), 1 / c.speed, 1e-4);
        EXPECT_LT(replay_error(*loaded.built->problem, result.trajectory, 10), 1e-6);
      }
    }
}

/// No given durations improve on the optimal ones, and with them the costs match the file with
/// those durations.
TEST(LinearControls, BestDurationsBeatGivenOnes) {
  constexpr const char* cases[] = {
      "constraints: {push: {residual: expression, rows: [u], upper: [1.2], soft: l1, weight: 0.4}}",
      "constraints: {push: {residual: expression, rows: [u - x], upper: [1.2], soft: l2, weight: "
      "9}}",
      "constraints: {cone: {residual: expression, rows: [u, 1.5 + x], cone: second_order, soft: "
      "l1, "
      "weight: 0.3, phases: first}}",
      "  wall: {residual: expression, rows: [u - v], activation: {kind: quadratic_barrier, upper: "
      "1}, "
      "weight: 8}"};
  for (const char* terms : cases)
    for (const bool first : {true, false}) {
      SCOPED_TRACE(fmt::format("{} {}", first, terms));
      const auto with = [&](std::string_view own) {
        return Loaded(first ? linear_phases(terms, own, "duration: 0.8")
                            : linear_phases(terms, "duration: 0.8", own));
      };
      const Loaded free = with(kChosenDuration);
      ASSERT_TRUE(free.built) << free.all();
      const SolveResult best = solved(free, "ipopt");
      ASSERT_EQ(best.status, SolveStatus::converged) << best.message;
      for (const char* solver : {"altro", "proxddp"}) {
        const SolveResult other = solved(free, solver);
        ASSERT_EQ(other.status, SolveStatus::converged) << solver << other.message;
        EXPECT_NEAR(other.cost, best.cost, 1e-6 * best.cost) << solver;
      }
      for (const double factor : {1.0, 0.95, 1.05}) {
        const Loaded fixed =
            with(fmt::format("duration: {:.17g}", best.trajectory.u(0)[0] * factor));
        ASSERT_TRUE(fixed.built) << fixed.all();
        const SolveResult given = solved(fixed, "ipopt");
        ASSERT_EQ(given.status, SolveStatus::converged) << given.message;
        if (factor != 1)
          EXPECT_GT(given.cost, best.cost * (1 + 1e-6));
        else
          EXPECT_NEAR(given.cost, best.cost, 1e-6 * best.cost);
      }
    }
}

/// Replayed with finer steps along the same lines; only the error of the rule remains.
TEST(LinearControls, AreReplayedUnchanged) {
  for (const char* integrator : {"rk4", "hermite_simpson"}) {
    const auto error = [&](const std::string& text) {
      const Loaded loaded(replaced(text, "rk4", integrator));
      const SolveResult result = solved(loaded, "ipopt");
      EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
      return replay_error(*loaded.built->problem, result.trajectory, 10);
    };
    const double ratio = error(kSwing) / error(halved(kSwing));
    EXPECT_GT(ratio, 10) << integrator;
    EXPECT_LT(ratio, 26) << integrator;
  }
}

TEST(LinearControls, BeginAtTheGivenFirstControl) {
  const std::string text =
      replaced(replaced(kSwing, "  - {name: start, choose: none}\n", ""), "{values: {theta: 0.4}}",
               "{values: {theta: 0.4}, previous_control: 0.5}");
  const Loaded loaded(text);
  const SolveResult result = solved(loaded, "box_ddp");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_EQ(result.trajectory.x(0)[2], 0.5);
  EXPECT_LT(result.trajectory.x(1)[2], -1) << "where it would rather have begun";
}

TEST(LinearControls, CostsUseTheTrapezoidalRule) {
  const Loaded loaded(kSwing);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  Trajectory t = loaded.built->guess;
  const int last = t.knots();
  for (int k = 1; k <= last; ++k) {
    t.x(k) << 0.1 * k, 0, k;
    t.u(k - 1)[0] = k;
  }
  Evaluation values(problem);
  Evaluator(problem).evaluate(t, values);
  double expected = 0.5 * 20 * ((0.1 * last - 1) * (0.1 * last - 1));
  const std::vector<double>& times = problem.times();
  const auto effort = [](int k) { return 0.5 * 0.1 * k * k; };
  const auto way = [](int k) { return 0.5 * 0.2 * 0.01 * k * k; };
  for (int k = 1; k < last; ++k) {
    const double half = 0.5 * (times[k + 1] - times[k]);
    expected += half * (effort(k) + effort(k + 1));
    if (k <= 8) expected += half * (way(k) + way(k + 1));
  }
  EXPECT_NEAR(values.cost.sum(), expected, 1e-12 * expected);
}

TEST(LinearControls, AreRefinedAlongTheirLines) {
  const Loaded coarse(kSwing), fine(halved(kSwing));
  ASSERT_TRUE(coarse.built && fine.built);
  const SolveResult result = solved(coarse, "box_ddp");
  const Trajectory finer = on_grid(*coarse.built->problem, result.trajectory, *fine.built->problem);
  const std::vector<double> u = nodal_controls(result.trajectory), v = nodal_controls(finer);
  for (std::size_t k = 0; k + 1 < u.size(); ++k) {
    EXPECT_NEAR(v[2 * k], u[k], 1e-14);
    EXPECT_NEAR(v[2 * k + 1], 0.5 * (u[k] + u[k + 1]), 1e-14);
  }
  for (int k = 1; k < finer.knots(); ++k) EXPECT_NEAR(finer.u(k)[0], v[k], 1e-14) << k;
}

/// An earlier solution with its own columns: the nodal values are used.
TEST(LinearControls, BeginWithAnEarlierSolution) {
  const TemporaryFolder folder;
  const std::string file =
      folder.write("start.json", R"({"format": "conddp.solution/1", "trajectory": {
    "columns": {"x": ["theta", "omega", "torque"], "u": ["end/torque"]},
    "t": [0, 0, 0.4, 1],
    "x": [[0, 0, 0], [0, 0, 1], [0.2, 0.1, 2], [0.4, 0.1, -1]],
    "u": [[1], [2], [-1]]}})");
  const std::string guess = "initial_guess: {file: " + file + "}\n";
  const Loaded linear(kSwing + guess);
  ASSERT_TRUE(linear.built) << linear.all();
  const Trajectory& t = linear.built->guess;
  EXPECT_DOUBLE_EQ(t.u(0)[0], 1);
  EXPECT_NEAR(t.x(5)[2], 1.5, 1e-12);
  EXPECT_NEAR(t.u(4)[0], 1.5, 1e-12);
  EXPECT_NEAR(t.u(t.knots() - 1)[0], -1, 1e-12);
  const Loaded constant(replaced(replaced(kSwing, "controls: linear\n", ""),
                                 "  - {name: start, choose: none}\n", "") +
                        guess);
  ASSERT_TRUE(constant.built) << constant.all();
  EXPECT_DOUBLE_EQ(constant.built->guess.u(3)[0], 1) << "held from the node before";
}

TEST(LinearControls, AreNamedAtNodesAndKnotEnds) {
  const Loaded loaded(replaced(kSwing, "rk4", "trapezoidal"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  std::string names;
  for (const auto* columns : {&loaded.built->state_columns, &loaded.built->control_columns})
    for (const Column& column : *columns) names += column.name + " ";
  EXPECT_EQ(names, "theta omega torque end/torque slope_end/omega ");
}

// A first phase that chooses the state or durations leaves a given control alone.
TEST(LinearControls, GivenFirstControlIsNotChosen) {
  const Loaded loaded(replaced(
      replaced(kSwing, "{values: {theta: 0.4}}", "{values: {theta: 0.4}, previous_control: 1}"),
      "choose: none", "choose: [omega]"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(problem.nu(0), 1);
  Trajectory motion = loaded.built->guess;
  motion.u(0)[0] = 0.2;
  ASSERT_EQ(Evaluator(problem).simulate(motion), -1);
  EXPECT_NEAR(motion.x(1)[1], 0.2, 1e-15);
  EXPECT_EQ(motion.x(0)[problem.nx() - 1], 1);
  EXPECT_EQ(motion.x(1)[problem.nx() - 1], 1);
}

// Contacts that all phases hold cause forces at the last node, too: cones on them hold at both ends
// of the last knot.
TEST(LinearControls, HeldContactsHaveForcesAtTheLastNode) {
  const Loaded loaded(kStandingQuadruped +
                      "integrator: rk4\ncontrols: linear\nphases: [{knots: 3, dt: 0.01, contacts: "
                      "all}]\ncosts: {effort: {residual: control}}\nconstraints: {cones: "
                      "{residual: friction_cone, soft: l2, weight: 10}}\n");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const KnotModel& end = *loaded.built->problem->terminal().model;
  EXPECT_TRUE(end.step().has_control());
  EXPECT_EQ(end.constraints().size(), 4u);
  for (const DerivativeComparison& c :
       check_derivatives(*loaded.built->problem, loaded.built->guess))
    EXPECT_LT(c.error, kDerivativeTolerance) << c.knot << " " << c.row << " " << c.column;
}

TEST(LinearControls, ReportIncompatibleFeatures) {
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {
      {"rk4", "explicit_euler",
       "4:13: linear controls need an integrator that accounts for their change during a step"},
      {"rk4", "rk2",
       "4:13: linear controls need an integrator that accounts for their change during a step"},
      {"upper: 3}", "upper: 3, phases: first}",
       "14:3: bounds on linear controls hold in all phases"},
      {"{residual: control,", "{residual: control_rate,",
       "11:22: 'control_rate' needs controls that are constant between knots"},
      {"terminal:\n", "terminal:\n  lqr: {about: {values: {theta: 0}}}\n",
       "16:8: a regulator sets the control at the beginning of a knot, and linear controls are set "
       "at its end"},
  };
  for (const Case& c : cases)
    EXPECT_EQ(Loaded(replaced(kSwing, c.from, c.to)).first_error(), c.message);
  std::ifstream hopper(kProblems / "hopper_cycle.yaml");
  const std::string text(std::istreambuf_iterator<char>(hopper), {});
  const Loaded touching(replaced(text, "phases:", "controls: linear\nphases:"));
  EXPECT_NE(touching.all().find("linear controls cannot pass that"), std::string::npos)
      << touching.all();
  const Loaded discrete(
      "conddp: 1\nsystem: {states: [x], controls: [u], next: {x: x + u}}\ninitial_state: {}\n"
      "controls: linear\nphases: [{choose: none}, {knots: 3, dt: 1}]\n");
  EXPECT_EQ(discrete.first_error(),
            "4:11: a system that gives the next state itself has no controls between its knots");
}

TEST(LinearControls, BeginWithinTheirBounds) {
  const auto begun = [](const char* with) {
    return Loaded(replaced(replaced(kSwing, "  - {name: start, choose: none}\n", ""),
                           "{values: {theta: 0.4}}",
                           fmt::format("{{values: {{theta: 0.4}}, previous_control: {}}}", with)))
        .first_error();
  };
  EXPECT_EQ(begun("3"), "");
  EXPECT_EQ(begun("8"), "3:57: linear controls begin with 8 here, and may be -2 to 3");
}

// Only the initial control is chosen; the given state varies.
TEST(LinearControls, InstancesHaveOtherInitialStates) {
  const Loaded loaded(kSwing);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const std::vector<double> from = loaded.built->problem->initial_state(),
                            to = perturb_initial_state(*loaded.built->problem, 0.1, 1)
                                     .initial_state();
  for (int i = 0; i < 2; ++i) {
    EXPECT_NE(from[i], to[i]);
    EXPECT_NEAR(from[i], to[i], 0.1);
  }
  EXPECT_EQ(from[2], to[2]);
  const Loaded chosen(replaced(kSwing, "choose: none", "choose: theta"));
  ASSERT_TRUE(chosen.built) << chosen.all();
  const std::vector<double> own = chosen.built->problem->initial_state(),
                            moved = perturb_initial_state(*chosen.built->problem, 0.1, 1)
                                        .initial_state();
  EXPECT_EQ(own[0], moved[0]);
  EXPECT_NE(own[1], moved[1]);
}

// Collocation slopes are further controls that accelerations ignore.
TEST(LinearControls, AccelerationsSupportThemWithCollocation) {
  std::ifstream arm(kProblems / "arm_reach.yaml");
  std::string text(std::istreambuf_iterator<char>(arm), {});
  text =
      replaced(text, "phases:\n", "controls: linear\nphases:\n  - {name: start, choose: none}\n");
  text = replaced(text, "costs:\n",
                  "costs:\n  acceleration: {residual: joint_acceleration, weight: 1.0e-5}\n");
  const Loaded loaded(text, {"integrator=hermite_simpson"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_NO_THROW(Evaluator(*loaded.built->problem));
}

}  // namespace
}  // namespace conddp
