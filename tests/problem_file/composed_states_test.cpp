// Free durations together with remembered states, distance costs, swings, and times in expressions,
// and periodic motions with the previous control.
#include <cmath>
#include <fstream>
#include <sstream>

#include <fmt/format.h>

#include "analysis/certificate/replay.hpp"
#include "analysis/derivatives/derivative_check.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// A mass moves one meter; DURATION is its time, free or given, and TERMS its costs and
/// constraints.
constexpr std::string_view kComposedMotion = R"(conddp: 1
system: {states: {x: m, v: m/s}, controls: {u: N}, rate: {x: v, v: u - 0.2*v*v}}
initial_state: {values: {x: 0, v: 0}PREVIOUS}
integrator: rk4
phases:
  - {name: start, choose: none}
  - {name: first, knots: 6, DURATION}
  - {name: second, knots: 8, duration: 0.7}
TERMS
solver: {name: altro, tolerances: {stationarity: 1.0e-8}}
)";

constexpr std::string_view kFreeTime = "duration: 1, free_duration: {lower: 0.3, upper: 4}";

struct ComposedCase {
  const char *name, *previous, *terms;
};

/// Each has its optimal time strictly between the bounds.
constexpr ComposedCase kComposedCases[] = {
    {"soft by its distance", "", R"(costs:
  time: {residual: expression, rows: 1 + 0.1*x, activation: linear, weight: 2}
  effort: {residual: control, weight: 0.3}
constraints:
  slow: {residual: expression, rows: [v], upper: 0.55, soft: l1, weight: 1.5}
  between: {residual: expression, rows: {x: x, v: v}, lower: {x: -0.1}, upper: {x: 0.7, v: 0.9},
            soft: l1, weight: 0.4}
terminal: {constraints: {there: {residual: expression, rows: [x - 1, v]}}})"},
    {"soft norm and cone", "", R"(costs:
  time: {residual: expression, rows: 1 + 0.1*x, activation: linear, weight: 2}
  effort: {residual: control, weight: 0.3}
constraints:
  disc: {residual: state, columns: [x, v], reference: [0.5, 0.2], at_least: 0.4, soft: l1, weight: 2}
  cone: {residual: expression, rows: [v, 0.2 + x], cone: second_order, soft: l1, weight: 1}
terminal: {constraints: {there: {residual: expression, rows: [x - 1, v]}}})"},
    {"soft by its square", "", R"(costs:
  time: {residual: expression, rows: 1 + 0.1*x, activation: linear, weight: 2}
  effort: {residual: control, weight: 0.3}
constraints: {slow: {residual: expression, rows: [v], upper: 0.55, soft: l2, weight: 20}}
terminal: {constraints: {there: {residual: expression, rows: [x - 1, v]}}})"},
    {"control rate", ", previous_control: 0.4", R"(costs:
  time: {residual: expression, rows: 1 + 0.1*x, activation: linear, weight: 2}
  effort: {residual: control, weight: 0.3}
  smooth: {residual: control_rate, weight: 3}
terminal: {constraints: {there: {residual: expression, rows: [x - 1, v]}}})"},
    {"previous control in a row", ", previous_control: 0.4", R"(costs:
  time: {residual: expression, rows: 1 + 0.1*x, activation: linear, weight: 2}
  smooth: {residual: expression, rows: "2*u - previous[u]", weight: 0.5}
terminal: {constraints: {there: {residual: expression, rows: [x - 1, v]}}})"},
    {"times in rows", "", R"(costs:
  effort: {residual: control, weight: 0.3}
  track: {residual: expression, rows: [x - 0.3*t, v - 0.5*cos(phase_time)*sin(final_time)], weight: 2}
terminal:
  costs:
    time: {residual: expression, rows: [x + final_time + 0.2*t^2 + phase_time], activation: linear}
  constraints: {there: {residual: expression, rows: [x - 1, v]}})"},
    {"integrals and the control rate", ", previous_control: 0.4", R"(integrals:
  work: 0.5*u^2
  push: {rows: u*v + 0.1*t, phases: first}
costs:
  time: {residual: expression, rows: 1 + 0.1*x, activation: linear, weight: 2}
  effort: {residual: control, weight: 0.05}
  smooth: {residual: control_rate, weight: 0.5}
  slow: {residual: expression, rows: work*v, weight: 0.1}
terminal:
  costs:
    push: {residual: expression, rows: [push - 0.3], weight: 2}
    battery: {residual: expression, rows: work, activation: linear}
  constraints: {there: {residual: expression, rows: [x - 1, v]}})"}};

std::string composed_text(const ComposedCase& c, std::string_view duration) {
  std::string text = replaced(kComposedMotion, "PREVIOUS", c.previous);
  text = replaced(text, "TERMS", c.terms);
  if (!duration.starts_with("duration: 1, free"))
    text = replaced(text, "  - {name: start, choose: none}\n", "");
  return replaced(text, "DURATION", std::string(duration));
}

SolveResult solve_composed(const Loaded& loaded, const char* solver) {
  return solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
}

void expect_exact_derivatives(const Loaded& loaded) {
  Trajectory at = loaded.built->guess;
  for (int k = 0; k <= at.knots(); ++k)
    for (int i = 0; i < at.nx(); ++i) at.x(k)[i] += 0.1 * std::sin(1 + 3 * k + i);
  for (int k = 0; k < at.knots(); ++k)
    for (int i = 0; i < at.u(k).size(); ++i) at.u(k)[i] += 0.1 * std::cos(2 + k + 5 * i);
  for (const DerivativeComparison& c : check_derivatives(*loaded.built->problem, at))
    EXPECT_LT(c.error, kDerivativeTolerance)
        << "knot " << c.knot << ", row " << c.row << ", column " << c.column;
}

TEST(ComposedStates, DerivativesMatchDualNumbers) {
  for (const ComposedCase& c : kComposedCases) {
    SCOPED_TRACE(c.name);
    const Loaded loaded(composed_text(c, kFreeTime));
    ASSERT_TRUE(loaded.built) << loaded.all();
    expect_exact_derivatives(loaded);
  }
}

/// No given duration improves on the optimal one, and with it the costs match the file with that
/// duration.
TEST(ComposedStates, BestDurationBeatsFixedDurations) {
  for (const ComposedCase& c : kComposedCases) {
    SCOPED_TRACE(c.name);
    const Loaded free(composed_text(c, kFreeTime));
    ASSERT_TRUE(free.built) << free.all();
    for (const char* solver : {"altro", "proxddp", "ipopt"}) {
      SCOPED_TRACE(solver);
      const SolveResult best = solve_composed(free, solver);
      ASSERT_EQ(best.status, SolveStatus::converged) << best.message;
      const double duration = best.trajectory.u(0)[0];
      EXPECT_GT(duration, 0.31);
      EXPECT_LT(duration, 3.9);
      for (const double factor : {1.0, 0.95, 1.05}) {
        const Loaded fixed(composed_text(c, fmt::format("duration: {:.17g}", duration * factor)));
        ASSERT_TRUE(fixed.built) << fixed.all();
        const SolveResult other = solve_composed(fixed, "ipopt");
        ASSERT_EQ(other.status, SolveStatus::converged) << other.message;
        if (factor != 1) {
          EXPECT_GT(other.cost, best.cost * (1 + 1e-5));
          continue;
        }
        EXPECT_NEAR(other.cost, best.cost, 1e-6 * best.cost);
        const auto own =
            cost_by_name(*free.built->problem, NodeValues(*free.built->problem, best.trajectory));
        const auto given = cost_by_name(*fixed.built->problem,
                                        NodeValues(*fixed.built->problem, other.trajectory));
        ASSERT_EQ(own.size(), given.size());
        double sum = 0;
        for (std::size_t i = 0; i < own.size(); ++i) {
          EXPECT_EQ(own[i].first, given[i].first);
          EXPECT_NEAR(own[i].second, given[i].second, 1e-4 * best.cost) << own[i].first;
          sum += own[i].second;
        }
        EXPECT_NEAR(sum, best.cost, 1e-9 * best.cost);
        const auto missed =
            soft_violations(*free.built->problem, best.trajectory, best.constraint_values);
        const auto missed_there =
            soft_violations(*fixed.built->problem, other.trajectory, other.constraint_values);
        ASSERT_EQ(missed.size(), missed_there.size());
        for (std::size_t i = 0; i < missed.size(); ++i)
          EXPECT_NEAR(missed[i].value, missed_there[i].value, 1e-4) << missed[i].name;
      }
    }
  }
}

TEST(ComposedStates, KnotsStoreThePreviousControlAfterDurations) {
  const Loaded loaded(composed_text(kComposedCases[3], kFreeTime));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(loaded.built->state_columns[2].name, "start/duration/first");
  EXPECT_EQ(loaded.built->state_columns[3].name, "previous/u");
  Trajectory t = loaded.built->guess;
  t.u(0)[0] = 2.5;
  for (int k = 1; k < t.knots(); ++k) t.u(k)[0] = k;
  ASSERT_EQ(Evaluator(problem).simulate(t), -1);
  EXPECT_EQ(t.x(1)[3], 0.4) << "that of the file";
  for (int k = 2; k <= t.knots(); ++k) {
    EXPECT_EQ(t.x(k)[2], 2.5);
    EXPECT_EQ(t.x(k)[3], k - 1);
  }
  EXPECT_DOUBLE_EQ(cost_by_name(problem, NodeValues(problem, t))[2].second,
                   1.5 * ((1 - 0.4) * (1 - 0.4) * 2.5 / 6 + 5 * 2.5 / 6 + 8 * 0.7 / 8));
}

TEST(ComposedStates, AreReplayed) {
  const Loaded loaded(composed_text(kComposedCases[3], kFreeTime));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve_composed(loaded, "altro");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const Replay replayed = replay(*loaded.built->problem, result.trajectory, result.feedback.K, 1);
  EXPECT_LT(replayed.controls.deviation, 1e-8);
  EXPECT_LT(replayed.feedback.deviation, 1e-8);
}

/// Rows depend on the state, the control, and all times, including durations in the state.
TEST(ComposedStates, RowTimesFollowTheDurations) {
  const std::string text = R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u}}
initial_state: {values: {x: 3}}
phases:
  - {choose: none}
  - {name: a, knots: 2, duration: 1, free_duration: {}}
  - {name: leap, jump: {x: 2*x}}
  - {name: b, knots: 2, duration: 0.5, refine: {first: 1, ratio: 0.25}}
  - {name: c, knots: 2, duration: 2, free_duration: {}}
costs:
  times: {residual: expression, rows: [x + t, x + phase_time, x + final_time]}
terminal: {costs: {times: {residual: expression, rows: [x + t, x + phase_time, x + final_time]}}}
solver: {name: altro}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  Trajectory t = loaded.built->guess;
  t.u(0) << 3, 5;
  ASSERT_EQ(Evaluator(problem).simulate(t), -1);
  const std::vector<double> times = problem.times(t);
  const double phases[] = {0, 0, 1.5, 0, 0, 0.1, 0, 2.5, 5};
  for (int k = 1; k <= problem.knots(); ++k) {
    if (problem.knot(k).model->costs().empty()) continue;  // the jump
    const KnotModel& model = *problem.knot(k).model;
    const CostTerm& cost = model.costs()[0];
    const auto data = model.system().create_data(double{});
    double rows[3];
    const ResidualInput<double> input{t.x(k).data(), nullptr,
                                      problem.knot(k).parameters + cost.parameters, *data};
    cost.residual->evaluate(input, rows);
    EXPECT_NEAR(rows[0] - t.x(k)[0], times[k], 1e-12) << k;
    EXPECT_NEAR(rows[1] - t.x(k)[0], phases[k], 1e-12) << k;
    EXPECT_NEAR(rows[2] - t.x(k)[0], 8.5, 1e-12) << k;
  }
  const Loaded fixed(
      replaced(replaced(replaced(text, "  - {choose: none}\n", ""), ", free_duration: {}", ""),
               ", free_duration: {}", ""));
  ASSERT_TRUE(fixed.built) << fixed.all();
  const double* end = fixed.built->problem->knot(fixed.built->problem->knots()).parameters;
  EXPECT_EQ(end[3], 3.5);
  EXPECT_EQ(end[4], 2);
  EXPECT_EQ(end[5], 3.5);
}

/// A name defined in the file is not the time.
TEST(ComposedStates, NamesInTheFileShadowTimes) {
  const std::string text = R"(conddp: 1
parameters: {final_time: 7}
system: {states: [x, phase_time], controls: [u], rate: {x: u, phase_time: 3}}
initial_state: {values: {x: 0}}
phases: [{knots: 2, duration: 1}]
costs: {own: {residual: expression, rows: [x*final_time + phase_time]}}
solver: {name: ipopt}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->problem->knot(0).model->parameter_count(), 2) << "reference and weight";
}

/// Steps of half a second with u = (1, 2, 3): the integral of u² is 0.5 (1 + 4 + 9), and 0.5 (4 +
/// 9) over the second phase.
TEST(ComposedStates, IntegralsGrowByStepTimesExpression) {
  const std::string text = R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u}}
integrals: {work: u^2, late: {rows: [u^2], phases: b}}
initial_state: {values: {x: 1}}
phases:
  - {name: a, knots: 1, duration: 0.5}
  - {name: leap, jump: {x: 2*x}}
  - {name: b, knots: 2, duration: 1}
costs: {effort: {residual: control}}
terminal: {constraints: {most: {residual: expression, rows: work, upper: 5}}}
solver: {name: altro}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.built->state_columns[1].name, "work");
  Trajectory t = loaded.built->guess;
  t.u(0)[0] = 1;
  t.u(2)[0] = 2;
  t.u(3)[0] = 3;
  ASSERT_EQ(Evaluator(*loaded.built->problem).simulate(t), -1);
  EXPECT_DOUBLE_EQ(t.x(4)[1], 7);
  EXPECT_DOUBLE_EQ(t.x(4)[2], 6.5);
  EXPECT_DOUBLE_EQ(t.x(2)[1], 0.5) << "behind the jump";
  expect_exact_derivatives(loaded);
  for (const auto& [from, to, error] :
       {std::tuple("work: u^2", "u: u^2", "3:13: the name 'u' of an integral is taken"),
        std::tuple("work: u^2", "work: \"[u, x]\"",
                   "3:13: an integral has one row, and 'work' has 2"),
        std::tuple("rows: [u^2]", "rows: [u^2], knots: [1]",
                   "3:30: an integral grows at all knots of its phases"),
        std::tuple("rows: [u^2]", "rows: [u^2], weight: 2", "3:44: unknown key 'weight'")}) {
    const Loaded wrong(replaced(text, from, to));
    EXPECT_TRUE(wrong.first_error().starts_with(error)) << wrong.all();
  }
}

/// Maximum distance of a mass in one second with limited work.
TEST(ComposedStates, IntegralsCanBeLimited) {
  const Loaded loaded(R"(conddp: 1
system: {states: [x, v], controls: [u], rate: {x: v, v: u}}
integrals: {work: 0.5*u^2}
initial_state: {values: {x: 0, v: 0}}
integrator: rk4
phases: [{name: go, knots: 200, duration: 1}]
costs: {small: {residual: control, weight: 1.0e-9}}
terminal:
  costs: {far: {residual: expression, rows: [-x], activation: linear}}
  constraints: {most: {residual: expression, rows: work, upper: 2}}
solver: {name: ipopt}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve_composed(loaded, "ipopt");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  // x(1) = ∫ (1 − t) u dt with ∫ u² = 4: u = c (1 − t), c²/3 = 4, x = c/3.
  EXPECT_NEAR(result.cost, -std::sqrt(12.0) / 3, 1e-4);
  EXPECT_NEAR(result.trajectory.x(200)[2], 2, 1e-8);
}

constexpr std::string_view kTimesInEquations = R"(conddp: 1
system:
  STATES
  controls: [u]
  let: {swing: sin(3*phase_time)}
  EQUATIONS
initial_state: {values: {x: 0.3}}
integrator: rk4
phases:
  - {name: start, choose: none}
  - {name: first, knots: 3, DURATION}
  - {name: leap, jump: {v: -v}}
  - {name: second, knots: 4, duration: 0.7}
  - {name: third, knots: 5, ALSO}
costs:
  effort: {residual: control}
  time: {residual: expression, rows: [x + final_time], activation: linear, weight: 0.3}
  near: {residual: expression, rows: [x - 0.2*t, v], weight: 3}
solver: {name: altro, tolerances: {stationarity: 1.0e-8}}
)";

std::string equations_with_times(bool second_order, const std::string& first,
                                 const std::string& third) {
  std::string text(kTimesInEquations);
  text = replaced(text, "STATES",
                  second_order ? "positions: [x]\n  velocities: [v]" : "states: [x, v]");
  const std::string force = "u + swing - x/final_time + 0.1*t";
  text = replaced(
      text, "EQUATIONS",
      second_order ? "acceleration: {v: " + force + "}" : "rate: {x: v, v: " + force + "}");
  text = replaced(replaced(text, "DURATION", first), "ALSO", third);
  if (first.find("free") == std::string::npos)
    text = replaced(text, "  - {name: start, choose: none}\n", "");
  return text;
}

TEST(ComposedStates, EquationsNamePhaseTimeAndFinalTime) {
  for (const bool second_order : {false, true}) {
    SCOPED_TRACE(second_order);
    const Loaded free(equations_with_times(second_order,
                                           "duration: 1, free_duration: {lower: 0.2, upper: 3}",
                                           "duration: 1.5, free_duration: {lower: 0.2, upper: 3}"));
    ASSERT_TRUE(free.built) << free.all();
    const Loaded fixed(equations_with_times(second_order, "duration: 0.8", "duration: 1.2"));
    ASSERT_TRUE(fixed.built) << fixed.all();
    expect_exact_derivatives(free);
    Trajectory a = free.built->guess, b = fixed.built->guess;
    a.u(0) << 0.8, 1.2;
    for (int k = 0; k < b.knots(); ++k)
      if (b.u(k).size() > 0) a.u(k + 1)[0] = b.u(k)[0] = std::sin(1 + k);
    ASSERT_EQ(Evaluator(*free.built->problem).simulate(a), -1);
    ASSERT_EQ(Evaluator(*fixed.built->problem).simulate(b), -1);
    const auto column = [](const Loaded& loaded, std::string_view name) {
      const auto& columns = loaded.built->state_columns;
      return std::ranges::find(columns, name, &Column::name) - columns.begin();
    };
    for (const char* name : {"x", "v", "t"})
      EXPECT_NEAR(a.x(a.knots())[column(free, name)], b.x(b.knots())[column(fixed, name)], 1e-12)
          << name;
    EXPECT_EQ(a.x(1)[column(free, "duration/first")], 0.8);
    EXPECT_EQ(a.x(a.knots())[column(free, "duration/third")], 1.2);
    Evaluation costs(*free.built->problem), given(*fixed.built->problem);
    Evaluator(*free.built->problem).evaluate(a, costs);
    Evaluator(*fixed.built->problem).evaluate(b, given);
    EXPECT_NEAR(costs.cost.sum(), given.cost.sum(), 1e-11 * std::abs(given.cost.sum()));
    // The file's own guess of the duration is the chosen value.
    EXPECT_EQ(free.built->guess.x(5)[column(free, "duration/first")], 1);
    const SolveResult best = solve_composed(free, "altro");
    ASSERT_EQ(best.status, SolveStatus::converged) << best.message;
    const SolveResult by_ipopt = solve_composed(free, "ipopt");
    ASSERT_EQ(by_ipopt.status, SolveStatus::converged) << by_ipopt.message;
    EXPECT_NEAR(best.cost, by_ipopt.cost, 1e-6 * std::abs(best.cost));
  }
}

/// By hand: x = x₀ + ∫ s ds over each phase, and T = 3 throughout.
TEST(ComposedStates, PhaseTimeRestartsWithEachPhase) {
  const Loaded loaded(R"(conddp: 1
systems:
  a: {states: [x], controls: [u], rate: {x: phase_time + 0*u}}
  b: {states: [x, y], controls: [u], rate: {x: phase_time + 0*u, y: final_time}}
initial_state: {values: {x: 0}}
phases:
  - {name: one, system: a, knots: 2, duration: 1}
  - {name: two, system: b, knots: 2, duration: 2}
costs: {effort: {residual: control}}
)");
  ASSERT_TRUE(loaded.built) << loaded.all();
  Trajectory t = loaded.built->guess;
  ASSERT_EQ(Evaluator(*loaded.built->problem).simulate(t), -1);
  EXPECT_NEAR(t.x(2)[0], 0.5, 1e-12);
  EXPECT_NEAR(t.x(4)[0], 0.5 + 2, 1e-12);
  EXPECT_NEAR(t.x(4)[1], 6, 1e-12);
}

/// Each phase is collocated with its own times: derivatives are exact, and free durations reach the
/// optimum of the given ones.
TEST(ComposedStates, EquationsWithTimesAreCollocated) {
  for (const char* rule : {"trapezoidal", "hermite_simpson", "radau3", "radau5"})
    for (const bool second_order : {false, true}) {
      SCOPED_TRACE(std::string(rule) + (second_order ? ", second order" : ""));
      const std::string integrator = std::string("integrator: ") + rule;
      const Loaded free(replaced(
          equations_with_times(second_order, "duration: 1, free_duration: {lower: 0.2, upper: 3}",
                               "duration: 1.5, free_duration: {lower: 0.2, upper: 3}"),
          "integrator: rk4", integrator));
      ASSERT_TRUE(free.built) << free.all();
      expect_exact_derivatives(free);
      const SolveResult best = solve_composed(free, "altro");
      ASSERT_EQ(best.status, SolveStatus::converged) << best.message;
      const SolveResult by_ipopt = solve_composed(free, "ipopt");
      ASSERT_EQ(by_ipopt.status, SolveStatus::converged) << by_ipopt.message;
      EXPECT_NEAR(best.cost, by_ipopt.cost, 1e-6 * std::abs(best.cost));
      const Eigen::VectorXd chosen = by_ipopt.trajectory.u(0);
      const Loaded fixed(
          replaced(equations_with_times(second_order, fmt::format("duration: {:.17g}", chosen[0]),
                                        fmt::format("duration: {:.17g}", chosen[1])),
                   "integrator: rk4", integrator));
      ASSERT_TRUE(fixed.built) << fixed.all();
      const SolveResult given = solve_composed(fixed, "ipopt");
      ASSERT_EQ(given.status, SolveStatus::converged) << given.message;
      EXPECT_NEAR(given.cost, by_ipopt.cost, 1e-7 * std::abs(given.cost));
      const auto replayed =
          replay(*free.built->problem, by_ipopt.trajectory, by_ipopt.feedback.K, 1);
      EXPECT_LT(replayed.controls.deviation, 1e-6);
    }
}

/// x' = s u with phase time s: a control in a knot moves x by m h u, where m is s at the middle,
/// and all rules are exact. From 0 to 1, the minimum of ½ Σ h u² is ½/Σ h m². The knots have h m² =
/// 0.5/16, 0.5 · 9/16, 1/4, and 9/4, together 2.8125.
TEST(ComposedStates, RestartedPhaseTimeIsOptimalByAllRules) {
  for (const char* rule : {"rk2", "rk4", "trapezoidal", "hermite_simpson", "radau3", "radau5"}) {
    const Loaded loaded(replaced(R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: phase_time*u}}
initial_state: {values: {x: 0}}
integrator: RULE
phases: [{name: one, knots: 2, duration: 1}, {name: two, knots: 2, duration: 2}]
costs: {effort: {residual: control}}
terminal: {constraints: {there: {residual: expression, rows: [x - 1]}}}
solver: {name: altro, tolerances: {stationarity: 1.0e-10, constraint: 1.0e-10}}
)",
                                 "RULE", rule));
    ASSERT_TRUE(loaded.built) << loaded.all();
    for (const char* solver : {"altro", "ipopt"}) {
      const SolveResult result = solve_composed(loaded, solver);
      ASSERT_EQ(result.status, SolveStatus::converged) << rule << ": " << result.message;
      EXPECT_NEAR(result.cost, 0.5 / 2.8125, 1e-8) << rule << ' ' << solver;
      EXPECT_NEAR(result.trajectory.u(3)[0], 1.5 / 2.8125, 1e-6) << rule << ' ' << solver;
    }
  }
}

/// A periodic motion with control-change costs has no first knot, so its starting point does not
/// matter.
TEST(ComposedStates, PeriodicMotionsComeBackToThePreviousControl) {
  constexpr std::string_view text = R"(conddp: 1
system: {states: [x, v], controls: [u], rate: {x: v, v: u - x - 0.3*v}}
initial_state: {values: {x: 0, v: 0}, previous_control: 0.2}
integrator: rk4
phases: [{name: start, choose: all}, {name: round, knots: 40, duration: 2}]
costs:
  smooth: {residual: control_rate, weight: 30}
  effort: {residual: control}
  track: {residual: expression, rows: [x - sin(2*pi*(t + PHASE)/2)], weight: 20}
terminal: {constraints: {cycle: {residual: cycle}}}
solver: {name: altro, tolerances: {stationarity: 1.0e-8}}
)";
  double cost = 0;
  for (const char* phase : {"0", "0.35"})
    for (const char* solver : {"altro", "proxddp", "ipopt"}) {
      SCOPED_TRACE(solver);
      const Loaded loaded(replaced(text, "PHASE", phase));
      ASSERT_TRUE(loaded.built) << loaded.all();
      const ShootingProblem& problem = *loaded.built->problem;
      EXPECT_EQ(loaded.built->state_columns[4].name, "start/previous/u");
      EXPECT_EQ(loaded.built->guess.u(0)[2], 0.2) << "where the search starts";
      EXPECT_EQ(loaded.built->guess.x(1)[5], 0.2);
      expect_exact_derivatives(loaded);
      const SolveResult result = solve_composed(loaded, solver);
      ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
      const int N = problem.knots();
      EXPECT_NEAR(result.trajectory.u(0)[2], result.trajectory.u(N - 1)[0], 1e-6);
      EXPECT_NEAR(result.trajectory.x(1)[5], result.trajectory.u(N - 1)[0], 1e-6);
      EXPECT_GT(std::abs(result.trajectory.u(N - 1)[0]), 0.1);
      if (cost == 0) cost = result.cost;
      EXPECT_NEAR(result.cost, cost, 1e-6 * cost);
      const Replay replayed = replay(problem, result.trajectory, result.feedback.K, 1);
      EXPECT_LT(replayed.feedback.deviation, 1e-6);
    }
  const Loaded named(replaced(replaced(text, "PHASE", "0"), "{residual: cycle}",
                              "{residual: cycle, equals: {x: 0, previous/u: 0}}"));
  ASSERT_TRUE(named.built) << named.all();
}

/// A hopper's hop with its swing and free phase durations: the touch-down cost belongs to an
/// instant.
TEST(ComposedStates, SwingsFollowFreeDurations) {
  const Loaded loaded(hopper_with_free_durations());
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const DerivativeComparison& c :
       check_derivatives(*loaded.built->problem, loaded.built->guess))
    EXPECT_LT(c.error, 1e-6) << "phase " << c.phase << ", row " << c.row << ", column " << c.column;
  const SolveResult result = solve_composed(loaded, "altro");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
}

/// A swing ends at the start of a phase with free duration: its cost there belongs to an instant.
TEST(ComposedStates, TouchDownCostIsIndependentOfDuration) {
  std::stringstream file;
  file << std::ifstream(kProblems / "hopper_cycle.yaml").rdbuf();
  const std::string given =
      replaced(file.str(), "  - {name: touch_down, impulse: all, restitution: 0}\n", "");
  const Loaded loaded(replaced(given, "knots: 15, dt: 0.01, contacts: all}",
                               "knots: 15, dt: 0.01, contacts: all, free_duration: {}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  Trajectory t = loaded.built->guess;
  const int own = loaded.built->plant.system->nx(), duration = problem.nu(0) - 1;
  const auto touch_down = [&] {
    for (const auto& [name, values] : costs_by_node(problem, NodeValues(problem, t)))
      if (name == "swing_foot") return std::pair(values[46], values[45]);
    return std::pair(0.0, 0.0);
  };
  const auto [moment, before] = touch_down();
  EXPECT_GT(moment, 0) << "the foot is not 0.3 m further on";
  const auto cost = [&] { return cost_by_name(problem, NodeValues(problem, t))[1].second; };
  const double effort = cost();
  for (int k = 1; k <= t.knots(); ++k) t.x(k)[own + duration] *= 2;
  EXPECT_DOUBLE_EQ(touch_down().first, moment);
  EXPECT_DOUBLE_EQ(touch_down().second, before) << "of another phase";
  EXPECT_GT(cost(), 1.1 * effort);
  for (const DerivativeComparison& c : check_derivatives(problem, loaded.built->guess))
    EXPECT_LT(c.error, 1e-6) << "knot " << c.knot << ", row " << c.row << ", column " << c.column;
  const Loaded fixed(given);
  ASSERT_TRUE(fixed.built) << fixed.all();
  for (const auto& [name, values] :
       costs_by_node(*fixed.built->problem, NodeValues(*fixed.built->problem, fixed.built->guess)))
    if (name == "swing_foot") {
      EXPECT_NEAR(values[46], moment, 1e-9 * moment);
    }
}

TEST(LinearSystem, GivesTheRateOfItsState) {
  constexpr std::string_view text = R"(conddp: 1
systems:
  a: {type: linear, gives: rate, A: [[0.6, 1.2], [-0.8, 3.4]], B: [[1], [1]]}
  b: {type: linear, gives: rate, A: [[4, 3], [-1, 0]], B: [[2], [-1]], c: [0.1, 0.2]}
initial_state: {state: [0, 2]}
phases:
  - {name: start, choose: none}
  - {name: one, system: a, knots: 20, duration: 0.2, free_duration: {lower: 0.05, upper: 1.9}}
  - {name: two, system: b, knots: 60, duration: 1.8, free_duration: {lower: 0.1, upper: 1.95}}
costs:
  track: {residual: state, columns: x/1, reference: [2]}
  effort: {residual: control}
terminal:
  costs: {goal: {residual: state, reference: [4, 2]}}
  constraints: {end: {residual: expression, rows: [final_time - 2]}}
solver: {name: ipopt}
)";
  const std::string by_equations = replaced(
      replaced(
          replaced(text, "{type: linear, gives: rate, A: [[0.6, 1.2], [-0.8, 3.4]], B: [[1], [1]]}",
                   "\n    states: [x0, x1]\n    controls: [u]\n"
                   "    rate: {x0: 0.6*x0 + 1.2*x1 + u, x1: -0.8*x0 + 3.4*x1 + u}"),
          "{type: linear, gives: rate, A: [[4, 3], [-1, 0]], B: [[2], [-1]], c: [0.1, 0.2]}",
          "\n    states: [x0, x1]\n    controls: [u]\n"
          "    rate: {x0: 4*x0 + 3*x1 + 2*u + 0.1, x1: -x0 - u + 0.2}"),
      "columns: x/1", "columns: x1");
  const Loaded linear{std::string(text)}, equations(by_equations);
  ASSERT_TRUE(linear.built) << linear.all();
  ASSERT_TRUE(equations.built) << equations.all();
  const SolveResult a = solve_composed(linear, "ipopt"), b = solve_composed(equations, "ipopt");
  ASSERT_EQ(a.status, SolveStatus::converged) << a.message;
  ASSERT_EQ(b.status, SolveStatus::converged) << b.message;
  EXPECT_NEAR(a.cost, b.cost, 1e-8 * b.cost);
  EXPECT_NEAR(a.trajectory.u(0)[0], b.trajectory.u(0)[0], 1e-6);
  EXPECT_NEAR(a.trajectory.u(0).sum(), 2, 1e-9);
}

}  // namespace
}  // namespace conddp
