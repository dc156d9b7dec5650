// The section `mpc` of problem files and its closed loops.
#include <algorithm>
#include <cmath>

#include "loaded_loop.hpp"
#include "problem_file/assemble/loop_commands.hpp"
#include "problem_file/expand/expand_problem.hpp"

namespace conddp {
namespace {

std::string pendulum_with(const std::string& mpc) { return std::string(kPendulum) + mpc + '\n'; }

// Bellman's principle: the tail of an optimum is optimal. Covers models with and without
// constraints, closed forms and robots, with contacts and flight.
TEST(MpcFile, FollowsFirstPlanOfExamplesWithShrinkingHorizons) {
  const struct {
    const char* name;
    double tick;
  } cases[] = {{"pendulum_swingup", 0.06},
               {"cartpole_swingup_closed_form", 0.03},
               {"cartpole_swingup", 0.03},
               {"arm_reach", 0.01},
               {"quadrotor_waypoints", 0.08},
               {"double_integrator_limits", 0.1},
               {"unicycle_obstacles", 0.05},
               {"powered_descent", 0.125},
               {"hopper_jump", 0.01},
               {"quadruped_trot", 0.02},
               // For these, solvers find the first plan only by restorations.
               {"collection/bryson_denham", 0.005},
               {"collection/bryson_denham_tight", 0.005}};
  for (const auto& c : cases) {
    SCOPED_TRACE(c.name);
    const LoadedLoop loop(
        text_of(c.name),
        {fmt::format("mpc={{horizon: 100, tick: {}, duration: {}, repeat: none, iterations: "
                     "tolerances}}",
                     c.tick, 4 * c.tick),
         "solver.tolerances.stationarity=1e-9"});
    ASSERT_TRUE(loop.mpc) << loop.all();
    const SolveResult plan = solve(*loop.built->problem, loop.mpc->controller.solver,
                                   loop.spec->solver.options, loop.built->guess);
    const ClosedLoopResult result = loop.run();
    ASSERT_GE(result.steps.size(), 3u);
    for (std::size_t k = 0; k < result.steps.size(); ++k)
      for (int i = 0; i < loop.built->problem->nx(); ++i)
        EXPECT_NEAR(result.steps[k].x[i], plan.trajectory.x(static_cast<int>(k))[i], 1e-6)
            << k << ' ' << i;
    for (const TickRecord& tick : result.ticks)
      EXPECT_EQ(tick.outcome, TickOutcome::planned) << tick.tick << to_string(tick.status);
  }
}

/// A double integrator under zero-order hold, with Q = I and R = 0.1 as rates and a long time line.
constexpr std::string_view kRegulated = R"(conddp: 1
system: {type: linear, A: [[1, 0.1], [0, 1]], B: [[0.005], [0.1]]}
initial_state: {state: [1, 0]}
phases: [{name: regulate, knots: 300, dt: 0.1}]
costs:
  state: {residual: state}
  effort: {residual: control, weight: 0.1}
constraints:
  force: {bounds: control, lower: -1, upper: 1}
solver: {name: box_fddp, tolerances: {stationarity: 1.0e-12}}
)";

// With its value function at the end of windows, the loop is that of the infinite horizon for any
// window length.
TEST(MpcFile, WindowsEndingInARegulatorReachTheOptimum) {
  for (const int knots : {1, 3, 5}) {
    const LoadedLoop loop(std::string(kRegulated) +
                          fmt::format("mpc: {{horizon: {}, tick: 0.1, duration: 20, iterations: "
                                      "tolerances, terminal: {{lqr: [0, 0]}}}}\n",
                                      0.1 * knots));
    ASSERT_TRUE(loop.mpc) << loop.all();
    const ClosedLoopResult result = loop.run();
    EXPECT_EQ(result.end, LoopEnd::finished);
    EXPECT_NEAR(result.cost, .7027180807405, 1e-9) << knots;
  }
  const LoadedLoop without(
      std::string(kRegulated) +
      "mpc: {horizon: 0.3, tick: 0.1, duration: 20, iterations: tolerances}\n");
  EXPECT_GT(without.run().cost, .71);
}

// Includes time after the end of the phases, where the last knot continues.
TEST(MpcFile, RegulatorEndsWindowsOfShortPhases) {
  const LoadedLoop loop(replaced(kRegulated, "knots: 300", "knots: 2") +
                        "mpc: {horizon: 0.3, tick: 0.1, duration: 20, iterations: tolerances, "
                        "terminal: {lqr: [0, 0]}}\n");
  ASSERT_TRUE(loop.mpc) << loop.all();
  EXPECT_NEAR(loop.run().cost, .7027180807405, 1e-9);
}

/// Cost of a loop with a low speed limit. `phases`: its phases; `terms`: text after the costs.
double cost_of_way(const std::string& phases, const std::string& terms, const char* solver) {
  const LoadedLoop loop(fmt::format(R"(conddp: 1
system: {{type: double_integrator}}
initial_state: {{values: {{"q/0": 0}}}}
integrator: rk4
phases:
{}costs:
  state:
    residual: state
    columns: ["q/0", "v/0"]
    reference: {{times: [0, 1.6, 1.7, 10], values: [[0, 0], [0, 0], [6, 0], [6, 0]]}}
    weights: {{"q/0": 10, "v/0": 0.1}}
  effort: {{residual: control, weight: 0.1}}
{}
solver: {{name: {}}}
mpc: {{horizon: 0.5, tick: 0.04, duration: 3, iterations: 1}}
)",
                                    phases, terms, solver));
  EXPECT_TRUE(loop.mpc) << loop.all();
  return loop.mpc ? loop.run().cost : -1;
}

/// A mass that comes to rest faster than its velocity bound allows.
constexpr const char* kSpeedLimit = R"(conddp: 1
system: {type: double_integrator}
initial_state: {values: {q/0: 1}}
phases: [{name: move, knots: 20, dt: 0.05}]
costs:
  state: {residual: state}
  effort: {residual: control, weight: 0.1}
constraints:
  force: {bounds: control, lower: -5, upper: 5}
  speed: {residual: state, columns: v/0, lower: -0.5, upper: 0.5}
terminal: {costs: {end: {residual: state, weight: 10}}}
mpc: {horizon: 1, tick: 0.02, duration: 4, terminal: keep, feedback: {rate: 200}}
)";

// A tick has no time to raise penalties, and its multipliers must not disturb the next tick.
TEST(MpcFile, FewIterationsATickAreAlmostAsGood) {
  for (const char* solver : {"altro", "proxddp"}) {
    const std::string by = std::string("solver.name=") + solver;
    const LoadedLoop whole(kSpeedLimit, {by, "mpc.iterations=tolerances"});
    const ClosedLoopResult best = whole.run();
    for (const int iterations : {1, 2, 3, 5}) {
      SCOPED_TRACE(fmt::format("{}, {}", solver, iterations));
      const LoadedLoop few(kSpeedLimit, {by, fmt::format("mpc.iterations={}", iterations)});
      const ClosedLoopResult result = few.run();
      EXPECT_NEAR(result.cost, best.cost, 1e-3 * best.cost);
      EXPECT_LT(result.violation, 2e-3);
    }
  }
}

// The only knot is that of the initial state, where no control can change the velocity.
TEST(MpcFile, ConstraintAbsentFromAllWindowsIsAnError) {
  const LoadedLoop loop(kSpeedLimit, {"phases.move.knots=1"});
  ASSERT_TRUE(loop.error());
  EXPECT_EQ(loop.error()->message,
            "the constraint 'speed' has no effect at repeated knots: the only one is the first, "
            "whose state is given");
  EXPECT_EQ(loop.error()->line, 10);
  EXPECT_TRUE(LoadedLoop(kSpeedLimit, {"phases.move.knots=2"}).mpc);
}

constexpr const char* kBarrier =
    "  wall: {residual: state, columns: [\"v/0\"], weight: 1.0e+3,\n"
    "         activation: {kind: quadratic_barrier, lower: -0.5, upper: 0.5}}";

// Windows of a phase begin in the previous phase, where nothing moves, and use the solver built
// there.
TEST(MpcFile, WindowsHaveTheWeightsOfTheirKnots) {
  const auto cost = [](const char* weight) {
    return cost_of_way(
        fmt::format("  - {{name: before, knots: 10, dt: 0.1, weights: {{wall: {}}}}}\n"
                    "  - {{name: way, knots: 30, dt: 0.1}}\n",
                    weight),
        kBarrier, "box_fddp");
  };
  EXPECT_EQ(cost("1.0e-3"), cost("1.0e+3"));
}

// Knots of one model are cut at window boundaries. Windows over knots with different models are
// rebuilt.
TEST(MpcFile, WindowsHaveTheSharesOfTheirKnots) {
  std::string apart;
  for (int k = 0; k < 40; ++k) apart += fmt::format("  - {{name: p{}, knots: 1, dt: 0.1}}\n", k);
  const std::string soft =
      "constraints:\n  wall: {bounds: state, lower: {\"v/0\": -0.5}, upper: {\"v/0\": 0.5}, "
      "weight: 3, soft: ";
  const struct {
    std::string terms;
    const char* solver;
  } cases[] = {{kBarrier, "box_fddp"}, {soft + "l1}", "altro"}, {soft + "l2}", "altro"}};
  for (const auto& [terms, solver] : cases)
    EXPECT_NEAR(cost_of_way("  - {name: way, knots: 40, dt: 0.1}\n", terms, solver),
                cost_of_way(apart, terms, solver), 1e-9)
        << terms;
}

TEST(MpcFile, WarnsThatNoGridIsRefined) {
  const LoadedLoop loop(
      pendulum_with("mesh: {error: 1.0e-4}\nmpc: {horizon: 0.5, tick: 0.1, duration: 0.2}"));
  EXPECT_TRUE(loop.mpc) << loop.all();
  EXPECT_EQ(loop.warnings(), 1) << loop.all();
}

TEST(MpcFile, FallbackRespectsControlBounds) {
  const LoadedLoop loop(
      pendulum_with("mpc: {horizon: 0.5, tick: 0.1, duration: 1, fallback: {after: 1, to: {values: "
                    "{theta: 1}}}}"));
  ASSERT_TRUE(loop.mpc) << loop.all();
  EXPECT_EQ(loop.mpc->controller.fallback->u[0], 3);
  EXPECT_EQ(loop.warnings(), 1) << loop.all();
}

TEST(MpcFile, WindowsKeepTheTerminalCostsOfTheFile) {
  const std::string mpc = "mpc: {horizon: 0.3, tick: 0.1, duration: 0.5, terminal: ";
  const LoadedLoop none(pendulum_with(mpc + "none}")), keep(pendulum_with(mpc + "keep}"));
  ASSERT_TRUE(none.mpc && keep.mpc) << keep.all();
  EXPECT_FALSE(none.mpc->controller.terminal);
  ASSERT_TRUE(keep.mpc->controller.terminal);
  EXPECT_EQ(keep.mpc->controller.terminal->model, keep.built->problem->terminal().model);
  EXPECT_NE(none.run().last_state, keep.run().last_state);
}

// Gains between ticks also belong to the optimum. The state jumps, and the answers of both solvers
// differ from the earlier plans.
TEST(MpcFile, IpoptDrivesTheLoopLikeOtherSolvers) {
  const auto run = [](const std::string& more) {
    const LoadedLoop loop(
        replaced(kPendulum, "box_ddp", more + ", tolerances: {stationarity: 1.0e-10}") +
        "mpc: {horizon: 0.5, tick: 0.1, duration: 2, delay: 0.02, feedback: {rate: 100}, terminal: "
        "keep, plant: {set: {system.mass: 1.1}}, disturbances: [{at: 0.55, jump: {omega: 1}}]" +
        (more == "ipopt" ? "}\n" : ", iterations: tolerances}\n"));
    EXPECT_TRUE(loop.mpc) << loop.all();
    return loop.run();
  };
  const ClosedLoopResult slow = run("ipopt"), fast = run("box_fddp");
  ASSERT_EQ(slow.steps.size(), fast.steps.size());
  for (std::size_t k = 0; k < slow.steps.size(); ++k) {
    EXPECT_NEAR(slow.steps[k].x[0], fast.steps[k].x[0], 1e-6) << k;
    EXPECT_NEAR(slow.steps[k].x[1], fast.steps[k].x[1], 1e-6) << k;
  }
  for (const TickRecord& tick : slow.ticks)
    EXPECT_EQ(tick.outcome, TickOutcome::planned) << tick.tick << to_string(tick.status);
}

TEST(MpcFile, IpoptHasNoRealTimeIteration) {
  const LoadedLoop loop(replaced(kPendulum, "box_ddp", "ipopt") +
                        "mpc: {horizon: 0.5, tick: 0.1, duration: 1, iterations: 3}\n");
  EXPECT_FALSE(loop.mpc);
  ASSERT_TRUE(loop.error());
  EXPECT_EQ(loop.error()->path, "mpc.iterations") << loop.all();
}

/// Ticks of a pendulum loop with their outcomes.
std::vector<TickRecord> ticks_with(const std::string& disturbances) {
  const LoadedLoop loop(pendulum_with(
      "mpc: {horizon: 0.5, tick: 0.05, duration: 3, terminal: keep, fallback: {after: "
      "2, to: {values: {theta: 0.1}}}, disturbances: [" +
      disturbances + "]}"));
  EXPECT_TRUE(loop.mpc) << loop.all();
  return loop.mpc ? loop.run().ticks : std::vector<TickRecord>();
}

TEST(MpcFile, LateAnswersTriggerFallbackAndRecovery) {
  for (const TickRecord& tick : ticks_with("{late: 1, at: 1, duration: 0.2}")) {
    const bool late = tick.tick >= 20 && tick.tick < 24;
    EXPECT_EQ(tick.outcome, late ? TickOutcome::late : TickOutcome::planned) << tick.tick;
    EXPECT_EQ(tick.fallback, tick.tick >= 21 && tick.tick < 24) << tick.tick;
  }
}

TEST(MpcFile, SeedDecidesWhichAnswersAreLate) {
  const auto late_of = [](const std::string& disturbance) {
    std::vector<int> late;
    for (const TickRecord& tick : ticks_with(disturbance))
      if (tick.outcome == TickOutcome::late) late.push_back(tick.tick);
    return late;
  };
  const std::vector<int> few = late_of("{late: 0.2, seed: 7}"),
                         many = late_of("{late: 0.5, seed: 7}");
  EXPECT_GT(few.size(), 4u);  // of 60
  EXPECT_LT(few.size(), 20u);
  EXPECT_GT(many.size(), few.size());
  EXPECT_TRUE(std::includes(many.begin(), many.end(), few.begin(), few.end()));
  EXPECT_NE(late_of("{late: 0.2, seed: 8}"), few);
  EXPECT_TRUE(late_of("{late: 0}").empty());
}

// Every answer is late from the first tick. The regulator still brings the pendulum upright;
// quasi-static controls let it fall.
TEST(MpcFile, FallbackMayUseRegulatorGains) {
  const auto last_angle = [](const std::string& to) {
    const LoadedLoop loop(
        replaced(replaced(kPendulum, "{theta: 0.1}", "{theta: 3.1}"), "costs:",
                 "costs:\n  upright: {residual: state, reference: {values: {theta: "
                 "3.141592653589793}}}") +
        "mpc: {horizon: 0.5, tick: 0.1, duration: 5, feedback: {rate: 100}, fallback: {after: 1, "
        "to: " +
        to + "}}\n");
    if (!loop.mpc) {
      ADD_FAILURE() << loop.all();
      return 0.0;
    }
    MpcOptions options = loop.mpc->controller;
    options.is_late = [](int) { return true; };
    Mpc controller(loop.built->problem, loop.built->guess, options);
    return run_closed_loop(controller, loop.mpc->loop).last_state[0];
  };
  EXPECT_NEAR(last_angle("{lqr: {values: {theta: 3.141592653589793}}}"), M_PI, 1e-2);
  EXPECT_GT(std::abs(last_angle("{values: {theta: 3.141592653589793}}") - M_PI), 0.1);
}

TEST(MpcFile, InvalidRegulatorsHaveTheirPlaces) {
  const LoadedLoop falling(pendulum_with(
      "mpc: {horizon: 0.5, tick: 0.1, duration: 1, terminal: {lqr: {values: {omega: 1}}}}"));
  EXPECT_FALSE(falling.mpc);
  EXPECT_TRUE(falling.first_error().starts_with("17:61: the state is not an equilibrium"))
      << falling.all();
  const LoadedLoop set(
      pendulum_with("mpc: {horizon: 0.5, tick: 0.1, duration: 1, fallback: {to: {lqr: {about: "
                    "initial, set: true}}}}"));
  EXPECT_FALSE(set.built);
  EXPECT_NE(set.all().find("a fallback has no terminal set"), std::string::npos) << set.all();
}

TEST(MpcFile, WindowsEndingInASetUseSupportingSolver) {
  const std::string mpc =
      "mpc: {horizon: 0.5, tick: 0.1, duration: 1, terminal: {lqr: {about: {values: {theta: 0}}, "
      "set: true}}}";
  const std::string state = "costs.state={residual: state}";
  const LoadedLoop named(pendulum_with(mpc), {state});
  EXPECT_FALSE(named.mpc);
  ASSERT_TRUE(named.error());
  EXPECT_EQ(named.error()->path, "mpc.terminal.lqr.set") << named.all();
  EXPECT_TRUE(named.error()->message.starts_with(
      "box_ddp does not support the constraint 'lqr' (terminal node); supported by altro"))
      << named.all();
  const LoadedLoop chosen(replaced(pendulum_with(mpc), "box_ddp", "auto"), {state});
  ASSERT_TRUE(chosen.mpc) << chosen.all();
  EXPECT_EQ(chosen.mpc->controller.solver, "altro");
  const ClosedLoopResult result = chosen.run();
  EXPECT_EQ(result.end, LoopEnd::finished);
  for (const TickRecord& tick : result.ticks) EXPECT_EQ(tick.outcome, TickOutcome::planned);
}

/// A cart-pole whose control may change by 2 N per second.
std::string limited_rate(const std::string& mpc) {
  return R"(conddp: 1
system: {type: cartpole}
initial_state: {values: {theta: 2.84}}
integrator: rk4
phases: [{name: balance, knots: 20, dt: 0.05}]
costs:
  state: {residual: state, reference: {values: {theta: 3.141592653589793}}, weights: {x: 1, theta: 10, "*": 0.1}}
  effort: {residual: control, weight: 0.1}
constraints:
  force: {bounds: control, lower: -10, upper: 10}
  rate: {residual: control_rate, lower: -2, upper: 2}
terminal:
  costs:
    upright: {residual: state, reference: {values: {theta: 3.141592653589793}}, weight: 20}
solver: {name: altro}
mpc: {horizon: 1, duration: 2, iterations: tolerances, )" +
         mpc + "}\n";
}

// The plant is the model: feedback only corrects the difference between a plan's straight lines and
// the motion.
TEST(MpcFile, FeedbackChangesLittleWithoutDisturbance) {
  for (const char* tick : {"0.05", "0.1"}) {
    const LoadedLoop none(limited_rate(fmt::format("tick: {}", tick)));
    const LoadedLoop often(limited_rate(fmt::format("tick: {}, feedback: {{rate: 200}}", tick)));
    ASSERT_TRUE(none.mpc && often.mpc) << often.all();
    const ClosedLoopResult a = none.run(), b = often.run();
    EXPECT_NEAR(a.cost, b.cost, 5e-2 * a.cost) << tick;
    for (std::size_t i = 0; i < a.last_state.size(); ++i)
      EXPECT_NEAR(a.last_state[i], b.last_state[i], 5e-2) << tick << ' ' << i;
  }
}

TEST(MpcFile, DiscreteSystemsMakeWholeKnots) {
  const struct {
    const char* mpc;
    const char* path;
  } cases[] = {
      {"tick: 0.1, duration: 0.55", "mpc.duration"},
      {"tick: 0.1, duration: 1, plant: {dt: 0.025}", "mpc.plant.dt"},
      {"tick: 0.1, duration: 1, feedback: {rate: 40}", "mpc.feedback.rate"},
      {"tick: 0.1, duration: 1, disturbances: [{at: 0.55, jump: 0.1}]", "mpc.disturbances.0.at"},
      {"tick: 0.15, duration: 1.5", "mpc.tick"}};
  for (const auto& c : cases) {
    const LoadedLoop loop(std::string(kRegulated) +
                          fmt::format("mpc: {{horizon: 3, {}}}\n", c.mpc));
    EXPECT_FALSE(loop.mpc) << c.mpc;
    ASSERT_TRUE(loop.error()) << c.mpc;
    EXPECT_EQ(loop.error()->path, c.path) << loop.all();
    EXPECT_NE(loop.all().find("gives the next state itself"), std::string::npos) << loop.all();
  }
  const std::string mpc = "mpc: {horizon: 1.2, tick: 0.2, duration: 2}\n";
  const std::string_view phases = "{name: regulate, knots: 300, dt: 0.1}";
  const LoadedLoop two(
      replaced(kRegulated, phases, "{name: a, knots: 4, dt: 0.1}, {name: b, knots: 9, dt: 0.2}") +
      mpc);
  ASSERT_TRUE(two.mpc) << two.all();
  EXPECT_EQ(two.run().end, LoopEnd::finished);
  const LoadedLoop odd(
      replaced(kRegulated, phases, "{name: a, knots: 3, dt: 0.1}, {name: b, knots: 9, dt: 0.2}") +
      mpc);
  EXPECT_FALSE(odd.mpc);
  EXPECT_NE(odd.all().find("cannot begin at 0.3 s"), std::string::npos) << odd.all();
}

/// A mass thrown down that bounces and must end at rest at a height of 1 m.
constexpr std::string_view kBounce = R"(conddp: 1
system: {states: {h: m, v: m/s}, controls: {u: N}, rate: {h: v, v: u - 9.81}}
initial_state: {values: {h: 1}}
integrator: rk4
phases:
  - {name: down, knots: 10, dt: 0.05}
  - {name: bounce, jump: {v: -0.8*v}}
  - {name: up, knots: 10, dt: 0.05}
costs:
  effort: {residual: control}
terminal:
  costs:
    rest: {residual: state, reference: {values: {h: 1}}, weight: 100}
solver: {name: box_fddp, tolerances: {stationarity: 1.0e-10}}
mpc: {horizon: 2, duration: 1, repeat: none, iterations: tolerances, )";

TEST(MpcFile, FollowsItsFirstPlanThroughAJump) {
  for (const char* more : {"tick: 0.05}", "tick: 0.1}", "tick: 0.1, feedback: {rate: 100}}"}) {
    const LoadedLoop loop(std::string(kBounce) + more);
    ASSERT_TRUE(loop.mpc) << loop.all();
    const SolveResult plan =
        solve(*loop.built->problem, "box_fddp", loop.spec->solver.options, loop.built->guess);
    const ClosedLoopResult result = loop.run();
    EXPECT_EQ(result.end, LoopEnd::finished);
    for (int i = 0; i < 2; ++i)
      EXPECT_NEAR(result.last_state[i], plan.trajectory.x(21)[i], 5e-3) << more << ' ' << i;
    for (const PlantStep& step : result.steps) {
      if (std::abs(step.time - 0.5) > 1e-9) continue;
      EXPECT_NEAR(step.x[1], plan.trajectory.x(11)[1], 1e-3) << more;  // after the jump
    }
    for (const TickRecord& tick : result.ticks)
      EXPECT_EQ(tick.outcome, TickOutcome::planned) << more << ' ' << tick.tick;
  }
}

TEST(MpcFile, PredictsAPlantThatJumpsDuringTheDelay) {
  const LoadedLoop loop(std::string(kBounce) + "tick: 0.1, delay: 0.05, plant: {dt: 0.01}}");
  ASSERT_TRUE(loop.mpc) << loop.all();
  const ClosedLoopResult result = loop.run();
  EXPECT_EQ(result.end, LoopEnd::finished);
  for (const TickRecord& tick : result.ticks) EXPECT_EQ(tick.outcome, TickOutcome::planned);
  EXPECT_NEAR(result.last_state[0], 1, 0.1);
}

/// A pole that its cart cannot hold at this angle.
constexpr std::string_view kBalanced = R"(conddp: 1
system: {type: cartpole}
initial_state: {values: {theta: 2.84}}
integrator: rk4
phases: [{name: balance, knots: 20, dt: 0.05}]
costs: {effort: {residual: control}}
solver: {name: box_fddp}
)";

TEST(MpcFile, WarnsAboutAFallbackWithoutEquilibrium) {
  const std::string mpc =
      "mpc: {horizon: 1, tick: 0.1, duration: 1, fallback: {to: {values: {theta: ";
  const auto all = [&](const std::string& theta) {
    const LoadedLoop loop(std::string(kBalanced) + mpc + theta + "}}}}\n");
    EXPECT_TRUE(loop.mpc) << loop.all();
    return loop.all();
  };
  EXPECT_EQ(all("3.14159"), "");
  EXPECT_NE(all("1").find("no equilibrium"), std::string::npos);
}

TEST(MpcFile, SimulatesAPlantWithOtherNumbers) {
  const std::string mpc = "mpc: {horizon: 0.5, tick: 0.1, duration: 1, plant: {";
  const LoadedLoop model(pendulum_with(mpc + "dt: 0.01}}"));
  const LoadedLoop heavy(pendulum_with(mpc + "set: {system.mass: 1.5}, dt: 0.01}}"));
  ASSERT_TRUE(model.mpc && heavy.mpc) << heavy.all();
  EXPECT_TRUE(model.mpc->loop.plant.empty());
  const ClosedLoopResult a = model.run(), b = heavy.run();
  EXPECT_EQ(a.steps.size(), 100u);
  EXPECT_EQ(b.steps.size(), 100u);
  EXPECT_NE(a.last_state, b.last_state);
}

constexpr const char* kArm = R"(conddp: 1
robot: {urdf: robots/arm7.urdf, configurations: {ready: {joints: {joint_2: 0.4, joint_4: -1.2}}}}
initial_state: {configuration: ready}
phases: [{name: hold, knots: 20, dt: 0.02}]
costs:
  posture: {residual: state, reference: ready, weight: 100}
  effort: {residual: control_gravity, weight: 1.0e-3}
initial_guess: {controls: quasi_static}
solver: {name: box_fddp}
mpc:
  horizon: 0.2
  tick: 0.02
  duration: 0.6
  plant: {dt: 0.005}
  disturbances: [{at: 0.2, frame: tool, force: [0, 30, 0], duration: 0.1}]
  fallback: {after: 2, to: {configuration: ready}}
)";

TEST(MpcFile, PlantErrorsNameTheSettingAboveTheKey) {
  const std::string text = replaced(kArm, "plant: {dt: 0.005}",
                                    "plant:\n    set:\n      robot.payloads.link_7.mass: 1\n"
                                    "      robot.payloads.nowhere.mass: 1");
  const LoadedLoop loop(text);
  ASSERT_TRUE(loop.error());
  const auto above =
      text.begin() + static_cast<std::ptrdiff_t>(text.find("robot.payloads.nowhere"));
  EXPECT_EQ(loop.error()->line, 1 + std::count(text.begin(), above, '\n')) << loop.error()->message;
}

// Keys of 'set' contain dots; the following text is one of them.
TEST(MpcFile, PathAddsNewPlantSettings) {
  for (const char* plant : {"", "plant: {dt: 0.01}", "plant: {set: {system.length: 0.9}}"}) {
    const LoadedLoop loop(
        pendulum_with(std::string("mpc: {horizon: 0.5, tick: 0.1, duration: 1, ") + plant + "}"),
        {"mpc.plant.set.system.mass=1.5"});
    ASSERT_TRUE(loop.mpc) << loop.all();
    EXPECT_EQ(loop.spec->mpc->plant.settings.back().key.value, "system.mass");
  }
}

TEST(MpcFile, PlantSettingsAcceptMappingsOrPaths) {
  for (const char* plant :
       {"{system: {mass: 1.5, length: 0.9}}", "{system.mass: 1.5, system.length: 0.9}"}) {
    const LoadedLoop loop(pendulum_with(
        std::string("mpc: {horizon: 0.5, tick: 0.1, duration: 1, plant: {set: ") + plant + "}}"));
    ASSERT_TRUE(loop.mpc) << loop.all();
    const auto& settings = loop.spec->mpc->plant.settings;
    ASSERT_EQ(settings.size(), 2u);
    EXPECT_EQ(settings[0].key.value, "system.mass");
    EXPECT_EQ(settings[1].key.value, "system.length");
  }
}

TEST(MpcFile, UnnamedConditionsTakeTheResidualName) {
  const LoadedLoop loop(
      pendulum_with("mpc: {horizon: 0.5, tick: 0.1, duration: 1, stop_when: {residual: state, "
                    "columns: theta, upper: 3}}"));
  ASSERT_TRUE(loop.mpc) << loop.all();
  ASSERT_EQ(loop.spec->mpc->stop_when.size(), 1u);
  EXPECT_EQ(loop.spec->mpc->stop_when[0].function.name.value, "state");
}

// The controller overestimates the motor.
TEST(MpcFile, PlantHasItsOwnMotorLimits) {
  const std::string mpc =
      "mpc: {horizon: 0.5, tick: 0.1, duration: 1, terminal: keep, plant: {set: ";
  const auto largest = [&](const std::string& set) {
    const LoadedLoop loop(pendulum_with(mpc + set + "}}"));
    EXPECT_TRUE(loop.mpc) << loop.all();
    double most = 0;
    for (const PlantStep& step : loop.run().steps) most = std::max(most, std::abs(step.u[0]));
    return most;
  };
  EXPECT_GT(largest("{system.mass: 1}"), 1);
  EXPECT_EQ(largest("{constraints.torque.upper: 0.5, constraints.torque.lower: -0.5}"), 0.5);
  EXPECT_EQ(largest("{constraints.weak: {bounds: control, lower: -0.25, upper: 0.25}}"), 0.25);
  const LoadedLoop unknown(pendulum_with(mpc + "{constraints.torqe.upper: 0.5}}}"));
  EXPECT_FALSE(unknown.mpc);
}

TEST(MpcFile, PlantAcceptsOnlyControlBounds) {
  const LoadedLoop loop(
      replaced(pendulum_with("mpc: {horizon: 0.5, tick: 0.1, duration: 1, plant: {set: "
                             "{constraints.rate.upper: 9}}}"),
               "constraints:\n",
               "constraints:\n  rate: {residual: state, columns: omega, upper: 8}\n"),
      {"solver.name=altro"});
  ASSERT_TRUE(loop.error());
  EXPECT_EQ(loop.error()->message,
            "the only constraints of a plant are hard bounds on the control");
}

TEST(MpcFile, PushesAFrameForTheGivenTime) {
  const LoadedLoop loop(kArm);
  ASSERT_TRUE(loop.mpc) << loop.all();
  ASSERT_EQ(loop.mpc->loop.plant.size(), 3u);  // before, during and after the push
  const ClosedLoopResult result = loop.run();
  const auto speed = [&](double time) -> double {
    for (const PlantStep& step : result.steps)
      if (std::abs(step.time - time) < 1e-9)
        return Eigen::Map<const Eigen::VectorXd>(step.x.data() + 7, 7).cwiseAbs().maxCoeff();
    return NAN;
  };
  EXPECT_LT(speed(0.2), 1e-6);
  EXPECT_GT(speed(0.25), 1e-2);
  EXPECT_EQ(result.end, LoopEnd::finished);
}

// A push at the pole tip leaves the cart-pole without an equilibrium: the regulator uses the model.
TEST(MpcFile, RegulatorIgnoresPushesOnThePlant) {
  const LoadedLoop loop(
      text_of("cartpole_swingup"),
      {"terminal={lqr: {joints: {hinge: 3.141592653589793}}}",
       "mpc={horizon: 0.5, tick: 0.03, duration: 1, terminal: keep, plant: {set: {gravity: [0.1, "
       "0, "
       "-9.81]}}, disturbances: [{at: 0.3, frame: tip, force: [1, 0, 0], duration: 0.1}]}"});
  ASSERT_TRUE(loop.mpc) << loop.all();
  EXPECT_EQ(loop.mpc->loop.plant.size(), 3u);
}

TEST(MpcFile, FallbackHoldsItsStateByQuasiStaticControls) {
  LoadedLoop loop(kArm, {"mpc.disturbances=[]"});
  ASSERT_TRUE(loop.mpc) << loop.all();
  loop.mpc->controller.is_late = [](int) { return true; };
  const ClosedLoopResult result = loop.run();
  for (int i = 0; i < 14; ++i) EXPECT_NEAR(result.last_state[i], result.steps[0].x[i], 1e-6) << i;
  EXPECT_TRUE(result.ticks.back().fallback);
}

TEST(MpcFile, FallbackNamesItsState) {
  const LoadedLoop stated(kArm);
  for (const char* name : {"ready", "initial"}) {
    const LoadedLoop loop(kArm, {std::string("mpc.fallback.to=") + name});
    ASSERT_TRUE(loop.mpc) << loop.all();
    EXPECT_EQ(loop.mpc->controller.fallback->x, stated.mpc->controller.fallback->x);
    EXPECT_EQ(expand_problem(*loop.built)["mpc"]["fallback"]["to"], name);
  }
  const LoadedLoop unknown(kArm, {"mpc.fallback.to=standing"});
  ASSERT_TRUE(unknown.error());
  EXPECT_NE(unknown.all().find("standing"), std::string::npos) << unknown.all();
}

TEST(MpcFile, StopsIfAConditionFails) {
  const LoadedLoop loop(pendulum_with(
      "mpc: {horizon: 0.5, tick: 0.05, duration: 5, stop_when: {up: {residual: state, columns: "
      "theta, upper: 0.6}}, disturbances: [{at: 1, jump: {omega: 3}}]}"));
  ASSERT_TRUE(loop.mpc) << loop.all();
  const ClosedLoopResult result = loop.run();
  EXPECT_EQ(result.end, LoopEnd::stopped);
  EXPECT_GT(result.last_state[0], 0.6);
}

// The file's own gait has two cycles of 0.15 m.
TEST(MpcFile, WalksOnIfTheGaitRepeats) {
  Diagnostics out;
  const auto two =
      read_problem_text(text_of("quadruped_trot"), kProblems / "test.yaml",
                        {"mpc={horizon: 0.4, tick: 0.02, duration: 2.4, repeat: gait}"}, out);
  ASSERT_TRUE(two) << format_diagnostics(out, false);
  const auto task = build_loop(two, {}, out);
  ASSERT_TRUE(task) << format_diagnostics(out, false);
  const LoadedLoop again(expanded_text(task->built));  // phases without a gait
  EXPECT_TRUE(again.mpc) << again.all();
  EXPECT_GT(task->built.problem->times().back(), 2.8);
  Mpc controller(task->built.problem, task->built.guess, task->mpc.controller);
  const ClosedLoopResult result = run_closed_loop(controller, task->mpc.loop);
  for (const TickRecord& tick : result.ticks)
    EXPECT_EQ(tick.outcome, TickOutcome::planned) << tick.tick << to_string(tick.status);
  EXPECT_GT(result.last_state[0], 0.5);          // x
  EXPECT_NEAR(result.last_state[1], 0, 0.05);    // y
  EXPECT_NEAR(result.last_state[2], 0.57, 0.1);  // z
}

/// The trot of the example problems with another section `mpc`.
LoadedLoop trot(const std::string& mpc, const std::vector<std::string>& more = {}) {
  std::vector<std::string> settings = {"mpc={horizon: 0.4, tick: 0.02, " + mpc + "}",
                                       "gait.cycles=4"};
  settings.insert(settings.end(), more.begin(), more.end());
  return LoadedLoop(text_of("quadruped_trot"), settings);
}

TEST(MpcFile, ReceivesEachCommandAtItsTime) {
  const LoadedLoop loop =
      trot("duration: 2, commands: [{at: 0, velocity: [0.2, 0, 0]}, {at: 0.8, turn: 0.3}]");
  ASSERT_TRUE(loop.mpc) << loop.all();
  const auto& commands = loop.mpc->loop.commands;
  ASSERT_EQ(commands.size(), 2u);
  EXPECT_EQ(commands[1].at, 0.8);
  const auto last_reference = [](const ShootingProblem& problem) {
    return std::vector<double>(problem.terminal().parameters.begin(),
                               problem.terminal().parameters.begin() + 7);
  };
  const auto none = last_reference(*loop.built->problem);
  const auto first = last_reference(*commands[0].numbers);
  const auto second = last_reference(*commands[1].numbers);
  EXPECT_NE(none, first);
  EXPECT_EQ(first[5], 0);          // straight on
  EXPECT_GT(second[5], 0.05);      // turned to the left
  EXPECT_LT(second[0], first[0]);  // from 0.8 s on the spot
  const ClosedLoopResult result = loop.run();
  for (const TickRecord& tick : result.ticks)
    EXPECT_EQ(tick.outcome, TickOutcome::planned) << tick.tick << to_string(tick.status);
  EXPECT_GT(result.last_state[5], 0.05);
  EXPECT_NEAR(result.last_state[2], 0.57, 0.1);
}

TEST(MpcFile, CommandUsesEarlierGaitCommandsOnly) {
  const std::vector<std::string> known = {
      "gait.commands=[{at: 0, velocity: [0.2, 0, 0]}, {at: 1.5, velocity: [1, 0, 0]}]"};
  const std::string mpc = "duration: 2, commands: [{at: 0.8, turn: 0.3}]";
  const LoadedLoop loop = trot(mpc, known);
  const LoadedLoop same = trot(mpc, {"gait.commands=[{at: 0, velocity: [0.2, 0, 0]}]"});
  ASSERT_TRUE(loop.mpc && same.mpc) << loop.all();
  EXPECT_EQ(loop.mpc->loop.commands[0].numbers->terminal().parameters,
            same.mpc->loop.commands[0].numbers->terminal().parameters);
}

TEST(MpcFile, StandsOnSimulatedContacts) {
  const LoadedLoop loop = trot("duration: 0.14, plant: {contacts: simulated, dt: 0.002}");
  ASSERT_TRUE(loop.mpc) << loop.all();
  EXPECT_EQ(loop.warnings(), 0) << loop.all();
  const ClosedLoopResult result = loop.run();
  EXPECT_EQ(result.end, LoopEnd::finished);
  EXPECT_EQ(loop.mpc->loop.plant[0].motion->closed_contacts(), 0b1111u);
  EXPECT_NEAR(result.last_state[2], 0.58, 0.02);
}

TEST(MpcFile, SimulatedContactsHoldNoFramesTogether) {
  const LoadedLoop loop = trot("duration: 0.14, plant: {contacts: simulated, dt: 0.002}",
                               {"contacts.pair={frame: lf_foot, to: rf_foot}"});
  EXPECT_FALSE(loop.mpc);
  EXPECT_NE(loop.all().find("the simulation knows contacts with the ground, and 'pair' holds two "
                            "frames together"),
            std::string::npos)
      << loop.all();
}

TEST(MpcFile, FallsToALowerGround) {
  const LoadedLoop loop = trot(
      "duration: 0.14, plant: {contacts: simulated, dt: 0.002, ground: [{half_space: {point: [0, "
      "0, -1], normal: [0, 0, 1]}}]}");
  ASSERT_TRUE(loop.mpc) << loop.all();
  EXPECT_NE(loop.all().find("'LF' begins 1 m above the ground"), std::string::npos) << loop.all();
  const ClosedLoopResult result = loop.run();
  EXPECT_EQ(loop.mpc->loop.plant[0].motion->closed_contacts(), 0u);
  EXPECT_LT(result.last_state[2], 0.5);
}

TEST(MpcFile, ReportsSimulatorsThatFindNoStep) {
  const LoadedLoop loop = trot(
      "duration: 0.14, plant: {contacts: simulated, dt: 0.002, ground: [{half_space: {point: [0, "
      "0, 0.3], normal: [0, 0, 1]}}]}");
  ASSERT_TRUE(loop.mpc) << loop.all();
  const ClosedLoopResult result = loop.run();
  EXPECT_EQ(result.end, LoopEnd::diverged);
  EXPECT_EQ(result.failure, "the simulator of contacts found no solution of the step");
}

TEST(MpcFile, SimulatedContactsHaveTheirOwnStepAndIntegrator) {
  const LoadedLoop loop =
      trot("duration: 0.1, plant: {contacts: simulated, integrator: semi_implicit_euler}");
  EXPECT_FALSE(loop.mpc);
  EXPECT_NE(loop.all().find("simulated contacts need the step of the plant"), std::string::npos);
  EXPECT_NE(loop.all().find("have an integrator of their own"), std::string::npos) << loop.all();
  const LoadedLoop stepped = trot(
      "duration: 0.1, plant: {contacts: simulated, integrator: rk4, dt: 0.002}, disturbances: "
      "[{at: 0.02, frame: trunk, force: [1, 0, 0], duration: 0.02}]");
  EXPECT_TRUE(stepped.mpc) << stepped.all();
  EXPECT_EQ(stepped.warnings(), 1) << stepped.all();
}

TEST(MpcFile, SimulatedContactErrorsSpeakOfTheLoop) {
  const std::string plant =
      "duration: 0.1, plant: {contacts: simulated, set: {contacts.LF.friction: 0.5}";
  const LoadedLoop above = trot(
      plant + ", dt: 0.002, ground: [{half_space: {point: [0, 0, -0.1], normal: [0, 0, 1]}}]}");
  ASSERT_TRUE(above.mpc) << above.all();
  EXPECT_EQ(above.warnings(), 4) << above.all();
  for (const Diagnostic& said : above.diagnostics.list()) {
    if (said.severity != Severity::kWarning) continue;
    EXPECT_EQ(said.path, "mpc.plant.contacts");
    EXPECT_NE(above.diagnostics.source_line(said).find("simulated"), std::string::npos);
  }
  EXPECT_EQ(above.run().end, LoopEnd::finished);
  const LoadedLoop without = trot(plant + "}");
  EXPECT_FALSE(without.mpc);
  ASSERT_EQ(without.diagnostics.error_count(), 1) << without.all();
  EXPECT_EQ(without.error()->message, "simulated contacts need the step of the plant");
}

TEST(MpcFile, SwingsMayBeginAtMeasuredFeet) {
  const std::string plant = "duration: 0.3, plant: {contacts: simulated, dt: 0.002}";
  EXPECT_FALSE(trot(plant).mpc->controller.swings);
  const LoadedLoop loop = trot(plant + ", swings: measured");
  ASSERT_TRUE(loop.mpc) << loop.all();
  const FootSwings& swings = *loop.mpc->controller.swings;
  EXPECT_EQ(swings.feet, 4);
  EXPECT_EQ(swings.swings.size(), 16u);
  std::vector<double> places(12);
  const std::vector<double>& x = loop.built->problem->initial_state();
  swings.find_feet(x.data(), places.data());
  for (const FootSwing& swing : swings.swings) {
    EXPECT_EQ(swing.nodes.size(), 13u);  // 0.24 s
    // Before the first swings nothing has moved: they begin at the feet.
    if (swing.nodes.front() >= 20) continue;
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(
          loop.built->problem->knot(swing.nodes.front()).parameters[swing.references.front() + c],
          places[3 * swing.foot + c], 1e-12);
  }
  EXPECT_EQ(expand_problem(*loop.built)["mpc"]["swings"], "measured");
  EXPECT_EQ(loop.run().end, LoopEnd::finished);
  const LoadedLoop none(
      pendulum_with("mpc: {horizon: 0.5, tick: 0.1, duration: 1, swings: measured}"));
  EXPECT_EQ(none.error()->message, "the file has no swings that could begin at the feet");
}

TEST(MpcFile, DistantGroundChangesNothing) {
  std::string far;
  for (int i = 0; i < 20; ++i)
    far +=
        fmt::format(", {{box: {{size: [1, 1, 1], placement: {{position: [{}, 0, 0]}}}}}}", 50 + i);
  const auto last_state = [](const std::string& more) {
    const LoadedLoop loop = trot(
        "duration: 0.3, plant: {contacts: simulated, dt: 0.002, ground: [ground" + more + "]}");
    return loop.mpc ? loop.run().last_state : std::vector<double>();
  };
  EXPECT_EQ(last_state(far), last_state(""));
}

TEST(MpcFile, ContactsCloseForAnyStepLength) {
  const LoadedLoop loop = trot("duration: 0.1, plant: {contacts: simulated, dt: 0.002}");
  ASSERT_TRUE(loop.mpc) << loop.all();
  PlantMotion& motion = *loop.mpc->loop.plant[0].motion;
  std::vector<double> x = loop.built->problem->initial_state();
  x[2] += 0.25;
  x[loop.built->plant.robot().nq + 2] = -130;  // 0.26 m per step
  const std::vector<double> u(loop.built->problem->nu(0), 0.0);
  motion.step(0, 0.002, u.data(), x.data());
  EXPECT_EQ(motion.closed_contacts(), 0b1111u);
  EXPECT_NEAR(x[2], 0.56, 0.01);
}

// The plant's own contact forces replace the model's phase forces.
TEST(MpcFile, PlantContactsReplaceModelContactForces) {
  const auto figures = [](const char* plant) {
    const LoadedLoop loop(
        text_of("quadruped_trot_cones"),
        {fmt::format("mpc={{horizon: 0.4, tick: 0.02, duration: 0.3, plant: {{{}}}}}", plant)});
    EXPECT_TRUE(loop.mpc) << loop.all();
    const ClosedLoopResult result = loop.mpc ? loop.run() : ClosedLoopResult{};
    return std::pair(result.cost, result.violation);
  };
  const auto scheduled = figures("dt: 0.002");
  const auto simulated = figures("dt: 0.002, contacts: simulated");
  EXPECT_GT(scheduled.second, 0.1);
  EXPECT_LT(simulated.second, 1e-6);
}

TEST(MpcFile, WarnsAboutTerminalCostsAtPathEnds) {
  const LoadedLoop keep = trot("duration: 0.1, terminal: keep");
  ASSERT_TRUE(keep.mpc) << keep.all();
  EXPECT_NE(keep.all().find("pulls every window to the end of the gait's path"), std::string::npos)
      << keep.all();
  const auto& said = keep.diagnostics.list();
  EXPECT_TRUE(std::any_of(said.begin(), said.end(), [](const Diagnostic& d) {
    return d.severity == Severity::kWarning && d.path == "mpc.terminal";
  })) << keep.all();
  EXPECT_EQ(trot("duration: 0.1, terminal: none").warnings(), 0);
  EXPECT_EQ(trot("duration: 0.1, terminal: keep", {"mpc.horizon=9"}).warnings(), 0);
}

TEST(MpcFile, RejectsCommandsAfterTheGait) {
  const LoadedLoop late = trot("duration: 9, repeat: hold, commands: [{at: 5, turn: 1}]");
  EXPECT_FALSE(late.mpc);
  ASSERT_TRUE(late.error());
  EXPECT_EQ(late.error()->path, "mpc.commands.0") << late.all();
  EXPECT_NE(late.all().find("the gait has ended by then"), std::string::npos) << late.all();
}

// Four cycles of 0.48 s with early touch-downs exceed the loop's 1.5 s.
TEST(MpcFile, RetimingReachesCommandsAfterTheLoop) {
  const auto loop = [](const std::string& more) {
    return trot(
        "duration: 1.5, plant: {contacts: simulated, dt: 0.002}, commands: [{at: 1.6, turn: "
        "1}]" +
        more);
  };
  const LoadedLoop late = loop(""), early = loop(", retime: {early: 0.06}");
  EXPECT_TRUE(early.mpc) << early.all();
  ASSERT_TRUE(late.error());
  EXPECT_EQ(late.error()->path, "mpc.commands.0.at");
  EXPECT_NE(late.all().find("the loop has ended by then: it lasts 1.5 s"), std::string::npos);
}

TEST(MpcFile, KnownCommandsPrecedeRepeatedCycles) {
  const auto at = [](const char* time) {
    return trot("duration: 1, repeat: gait",
                {fmt::format("gait.commands=[{{at: {}, turn: 1}}]", time)});
  };
  EXPECT_TRUE(at("1").mpc) << at("1").all();
  const LoadedLoop late = at("50");
  EXPECT_FALSE(late.mpc);
  ASSERT_TRUE(late.error());
  EXPECT_NE(late.all().find("the gait has ended by then: in the loop it lasts"), std::string::npos)
      << late.all();
}

TEST(MpcFile, UnknownContactKindIsOneError) {
  const LoadedLoop loop = trot("duration: 0.1, plant: {contacts: true, ground: [ground]}");
  EXPECT_EQ(loop.diagnostics.error_count(), 1) << loop.all();
}

TEST(MpcFile, MeaninglessRetimingHasItsPlace) {
  const struct {
    const char* mpc;
    const char* path;
    const char* message;
  } cases[] = {
      {"retime: {}", "mpc.retime", "this moves no phase"},
      {"retime: {early: 0.24}", "mpc.retime.early", "the shortest swing lasts 0.24 s"},
      {"retime: {early: 1e300}", "mpc.retime.early", "the shortest swing lasts 0.24 s"},
      {"retime: {late: 0.019}", "mpc.retime.late", "phases wait by whole ticks"},
      {"retime: {early: 0.06}, repeat: none", "mpc.retime", "moves the end of the phases"}};
  for (const auto& c : cases) {
    const LoadedLoop loop =
        trot(fmt::format("duration: 0.1, plant: {{contacts: simulated, dt: 0.002}}, {}", c.mpc));
    EXPECT_FALSE(loop.mpc) << c.mpc;
    ASSERT_TRUE(loop.error()) << c.mpc;
    EXPECT_EQ(loop.error()->path, c.path) << loop.all();
    EXPECT_NE(loop.error()->message.find(c.message), std::string::npos) << loop.all();
  }
}

TEST(MpcFile, PushesOtherPlantsOnSimulatedContacts) {
  const auto loop_with = [](const std::string& frame) {
    return trot(
        "duration: 0.2, plant: {contacts: simulated, dt: 0.002, set: "
        "{contacts.LF.friction: 0.5}}, disturbances: [{at: 0.04, frame: " +
        frame + ", force: [0, 200, 0], duration: 0.1}]");
  };
  const LoadedLoop pushed = loop_with("trunk");
  ASSERT_TRUE(pushed.mpc) << pushed.all();
  ASSERT_EQ(pushed.mpc->loop.plant.size(), 3u);
  const ClosedLoopResult result = pushed.run();
  EXPECT_EQ(result.end, LoopEnd::finished);
  EXPECT_GT(result.last_state[1], 1e-3);  // y
  const LoadedLoop unknown = loop_with("trunc");
  EXPECT_FALSE(unknown.mpc);
  ASSERT_EQ(unknown.diagnostics.error_count(), 1) << unknown.all();
  EXPECT_EQ(unknown.error()->path, "mpc.disturbances.0.frame");
}

// Touch-downs, two per cycle, may all be 0.2 s early.
TEST(MpcFile, RepeatingGaitLastsDespiteEarlyPhases) {
  Diagnostics out;
  const auto two = read_problem_text(
      text_of("quadruped_trot"), kProblems / "test.yaml",
      {"mpc={horizon: 0.4, tick: 0.02, duration: 2.4, repeat: gait, retime: {early: 0.2}, plant: "
       "{contacts: simulated, dt: 0.002}}"},
      out);
  ASSERT_TRUE(two) << format_diagnostics(out, false);
  const auto task = build_loop(two, {}, out);
  ASSERT_TRUE(task) << format_diagnostics(out, false);
  const double end = task->built.problem->times().back();
  EXPECT_GT(end - 0.2 * count_touch_downs(*task->built.problem_spec), 2.4 + 0.4 - 1e-9);
}

TEST(MpcFile, RetimingUsesTheContactsOfThePhases) {
  const LoadedLoop loop = trot(
      "duration: 0.1, plant: {contacts: simulated, dt: 0.002}, retime: {early: 0.06, late: 0.04}");
  ASSERT_TRUE(loop.mpc) << loop.all();
  const Retiming& retiming = *loop.mpc->controller.retiming;
  EXPECT_EQ(retiming.early, 0.06);
  EXPECT_EQ(retiming.late, 0.04);
  EXPECT_EQ(retiming.contacts[0], 0b1111u);
  EXPECT_EQ(retiming.contacts[10], 0b1001u);  // LF and RH
  EXPECT_EQ(retiming.contacts[22], 0b0110u);
}

TEST(MpcFile, DurationIsLimitedToExactTimes) {
  const LoadedLoop loop(replaced(kPendulum, "dt: 0.05", "dt: 5") +
                        "mpc: {horizon: 10, tick: 10, duration: 1.0e+6}\n");
  ASSERT_TRUE(loop.error());
  EXPECT_EQ(loop.error()->path, "mpc.duration") << loop.all();
}

TEST(MpcFile, DurationIsLimitedToTheLongestGait) {
  Diagnostics out;
  const auto once =
      read_problem_text(text_of("quadruped_trot"), kProblems / "test.yaml",
                        {"mpc={horizon: 0.4, tick: 0.02, duration: 1e4, repeat: gait}"}, out);
  ASSERT_TRUE(once) << format_diagnostics(out, false);
  EXPECT_FALSE(build_loop(once, {}, out));
  ASSERT_EQ(out.error_count(), 1);
  EXPECT_EQ(out.list().back().path, "mpc.duration");
}

TEST(MpcFile, ExpansionReadsBack) {
  const LoadedLoop once(kArm);
  ASSERT_TRUE(once.mpc) << once.all();
  const LoadedLoop again(expanded_text(*once.built));
  ASSERT_TRUE(again.mpc) << again.all();
  EXPECT_EQ(expand_problem(*again.built).at("mpc"), expand_problem(*once.built).at("mpc"));
  EXPECT_EQ(again.run().last_state, once.run().last_state);
}

TEST(MpcFile, IsExcludedFromTheProblemIdentity) {
  const Loaded without{std::string(kPendulum)};
  const Loaded with(pendulum_with("mpc: {horizon: 0.5, tick: 0.1, duration: 1}"));
  EXPECT_EQ(with.spec->definition, without.spec->definition);
}

}  // namespace
}  // namespace conddp
