// Integrals in closed loops: a window begins with the plant's accumulated value.
#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "loaded_loop.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// From 0 towards 3 in one second by x' = gain u with ∫u² ≤ 4. For gain 1, u = 2 throughout, with
/// cost ½ (2 − 3)² + ½ 0.1 · 4.
std::string budget_loop(std::string_view budget, std::string_view more) {
  return fmt::format(R"(conddp: 1
parameters: {{gain: 1}}
system: {{states: {{x: m}}, controls: {{u: m/s}}, rate: {{x: gain*u}}}}
initial_state: {{values: {{x: 0}}}}
integrator: rk4
phases: [{{name: go, knots: 10, dt: 0.1}}]
integrals: {{spent: u^2}}
costs: {{effort: {{residual: control, weight: 0.1}}}}
terminal:
  costs: {{far: {{residual: state, reference: {{values: {{x: 3}}}}}}}}
{}
initial_guess: {{controls: {{constant: {{u: 2}}}}}}
solver: {{name: altro, tolerances: {{stationarity: 1.0e-9, constraint: 1.0e-9}}}}
mpc: {{horizon: 100, tick: 0.1, duration: 1, repeat: none, iterations: tolerances{}}}
)",
                     budget, more);
}

constexpr std::string_view kAtTheEnd =
    "  constraints: {budget: {residual: expression, rows: [spent], upper: 4}}";
constexpr std::string_view kAlways =
    "  constraints: {budget: {residual: expression, rows: [spent], upper: 4}}\n"
    "constraints: {meanwhile: {residual: expression, rows: [spent], upper: 4}}";

// A window starting at 0 would spend the whole budget again.
TEST(MpcIntegral, BudgetCoversTheWholeLoop) {
  for (const std::string_view budget : {kAtTheEnd, kAlways})
    for (const char* more :
         {"", ", feedback: {rate: 50}", ", plant: {dt: 0.02}", ", delay: 0.05"}) {
      SCOPED_TRACE(fmt::format("{} {}", budget, more));
      const LoadedLoop loop(budget_loop(budget, more));
      ASSERT_TRUE(loop.mpc) << loop.all();
      const ClosedLoopResult result = loop.run();
      EXPECT_EQ(result.end, LoopEnd::finished);
      ASSERT_EQ(result.last_state.size(), 2u);
      EXPECT_NEAR(result.last_state[0], 2, 1e-5);
      EXPECT_NEAR(result.last_state[1], 4, 1e-5);
      for (const PlantStep& step : result.steps) EXPECT_NEAR(step.x[1], 4 * step.time, 1e-5);
    }
}

TEST(MpcIntegral, LoopStopsWithASpentBudget) {
  const LoadedLoop loop(budget_loop(
      kAtTheEnd, ", stop_when: {empty: {residual: expression, rows: [spent], upper: 1.9}}"));
  ASSERT_TRUE(loop.mpc) << loop.all();
  const ClosedLoopResult result = loop.run();
  EXPECT_EQ(result.end, LoopEnd::stopped);
  EXPECT_NEAR(result.end_time, 0.5, 1e-9);
}

/// A push lengthens the remaining way of the plant, but the total spent is the same.
TEST(MpcIntegral, BudgetHoldsOnAPlantUnlikeTheModel) {
  const LoadedLoop loop(budget_loop(
      kAtTheEnd,
      ", plant: {set: {parameters.gain: 0.7}, dt: 0.01}, disturbances: [{at: 0.45, jump: "
      "{x: -0.5}}]"));
  ASSERT_TRUE(loop.mpc) << loop.all();
  const ClosedLoopResult result = loop.run();
  EXPECT_NEAR(result.last_state[1], 4, 1e-5);
  double spent = 0;
  for (const PlantStep& step : result.steps) {
    EXPECT_NEAR(step.x[1], spent, 1e-12);
    spent += step.length * step.u[0] * step.u[0];
  }
  EXPECT_NEAR(result.last_state[1], spent, 1e-12);
  EXPECT_NEAR(result.last_state[0], 0.7 * 2 - 0.5, 1e-4);
}

/// Bellman's principle: the tail of an optimum is optimal if integral costs cover the whole motion.
/// Includes the previous control after the integrals, and times in them.
TEST(MpcIntegral, FollowsFirstPlanWithWholeMotionCosts) {
  const std::string swing = R"(conddp: 1
system: {type: pendulum}
initial_state: {values: {theta: 0.2}, previous_control: 0.3}
integrator: rk4
phases: [{name: first, knots: 6, dt: 0.05}, {name: second, knots: 8, dt: 0.05}]
integrals:
  work:
    rows: smooth_max(torque*omega, 0, 0.1)
  late: {rows: omega^2 + 2*t, phases: second}
costs: {effort: {residual: control, weight: 0.1}, rate: {residual: control_rate, weight: 0.05}}
terminal:
  costs:
    goal: {residual: state, reference: {values: {theta: 1}}, weight: 20}
    spent: {residual: expression, rows: [work - 0.1, late], weight: 5}
solver: {name: altro, tolerances: {stationarity: 1.0e-9}}
)";
  struct Case {
    std::string text;
    std::vector<std::string> settings;
    double tick;
  };
  const Case cases[] = {
      {swing, {}, 0.05},
      {text_of("hopper_jump"), {"integrals={work: {rows: \"v[knee]^2 + 0.1*u[hip]\"}}"}, 0.01}};
  for (const Case& c : cases) {
    std::vector<std::string> settings = c.settings;
    settings.push_back(
        fmt::format("mpc={{horizon: 100, tick: {}, duration: {}, repeat: none, "
                    "iterations: tolerances}}",
                    c.tick, 8 * c.tick));
    settings.emplace_back("solver.tolerances.stationarity=1e-9");
    const LoadedLoop loop(c.text, settings);
    ASSERT_TRUE(loop.mpc) << loop.all();
    const SolveResult plan = solve(*loop.built->problem, loop.mpc->controller.solver,
                                   loop.spec->solver.options, loop.built->guess);
    ASSERT_EQ(plan.status, SolveStatus::converged) << plan.message;
    const ClosedLoopResult result = loop.run();
    ASSERT_EQ(result.steps.size(), 8u);
    for (std::size_t k = 0; k < result.steps.size(); ++k)
      for (int i = 0; i < loop.built->problem->nx(); ++i)
        EXPECT_NEAR(result.steps[k].x[i], plan.trajectory.x(static_cast<int>(k))[i], 1e-6)
            << k << ' ' << i;
  }
}

/// The loop without integrals, step by step, with accumulated values. Gaps of integrals count as
/// gaps, so solvers reach the same plan along another path and with slightly different gains.
/// Without feedback these differences vanish.
TEST(MpcIntegral, UnusedIntegralsChangeNothing) {
  struct Case {
    bool feedback;
    std::vector<std::string> settings;
  };
  const Case cases[] = {{false, {}},
                        {true, {}},
                        {false, {"mpc.terminal={lqr: {values: {theta: 3.141592653589793}}}"}},
                        {false, {"mpc.disturbances=[{late: 0.5, seed: 3}]"}},
                        {false,
                         {"mpc.disturbances=[{late: 0.5, seed: 3}]",
                          "mpc.fallback={after: 1, to: {values: {theta: 3.141592653589793}}}"}},
                        {false, {"costs.smooth={residual: control_rate, weight: 0.01}"}}};
  for (const Case& c : cases) {
    SCOPED_TRACE(c.settings.empty() ? "" : c.settings.back());
    std::vector<std::string> settings = {"mpc.duration=0.9", "mpc.iterations=tolerances",
                                         "solver.tolerances.stationarity=1e-11",
                                         "mpc.disturbances=[{at: 0.5, jump: {omega: 0.3}}]"};
    settings.insert(settings.end(), c.settings.begin(), c.settings.end());
    std::string text = text_of("mpc/cartpole_balance");
    if (!c.feedback) text = replaced(text, "  delay: 0.01\n  feedback: {rate: 200}\n", "");
    const LoadedLoop plain(text, settings);
    settings.emplace_back("integrals={work: {rows: \"force^2 + omega\"}, way: x}");
    const LoadedLoop counting(text, settings);
    ASSERT_TRUE(plain.mpc && counting.mpc) << plain.all() << counting.all();
    const ClosedLoopResult a = plain.run(), b = counting.run();
    ASSERT_EQ(a.steps.size(), b.steps.size());
    const double tolerance = c.feedback ? 1e-3 : 1e-6;
    EXPECT_NEAR(a.cost, b.cost, tolerance * a.cost);
    double work = 0, way = 0;
    for (std::size_t k = 0; k < a.steps.size(); ++k) {
      const PlantStep& own = b.steps[k];
      for (int i = 0; i < 4; ++i) ASSERT_NEAR(own.x[i], a.steps[k].x[i], tolerance) << k;
      ASSERT_NEAR(own.x[4], work, 1e-9 * (1 + work)) << k;
      ASSERT_NEAR(own.x[5], way, 1e-9) << k;
      work += own.length * (own.u[0] * own.u[0] + own.x[3]);
      way += own.length * own.x[0];
    }
  }
}

TEST(MpcIntegral, RejectsSimulatedContacts) {
  const LoadedLoop loop(text_of("mpc/hopper_hops"), {"robot.urdf=robots/hopper.urdf",
                                                     "integrals={work: {rows: \"v[knee]^2\"}}"});
  EXPECT_FALSE(loop.mpc);
  EXPECT_NE(loop.all().find("plants with simulated contacts have no integrals"), std::string::npos)
      << loop.all();
}

}  // namespace
}  // namespace conddp
