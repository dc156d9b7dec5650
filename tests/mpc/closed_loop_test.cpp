#include "mpc/closed_loop.hpp"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "loop_cases.hpp"
#include "ocp/problem/cost_scale.hpp"

namespace conddp {
namespace {

using testing::shared;
using testing::with_terminal;

/// Largest difference between the plant's states and those of a trajectory at the same knots.
double distance(const ClosedLoopResult& loop, const Trajectory& plan) {
  double most = 0;
  for (std::size_t k = 0; k < loop.steps.size(); ++k)
    for (int i = 0; i < plan.nx(); ++i)
      most = std::max(most, std::abs(loop.steps[k].x[i] - plan.x(static_cast<int>(k))[i]));
  for (int i = 0; i < plan.nx(); ++i)
    most = std::max(most, std::abs(loop.last_state[i] - plan.x(plan.knots())[i]));
  return most;
}

// Bellman's principle: the tail of an optimum is optimal.
TEST(ClosedLoop, FollowsFirstPlanWithShrinkingHorizons) {
  struct Case {
    const char* name;
    ShootingProblem problem;
    double u;
  };
  Case cases[] = {{"pendulum", testing::pendulum_swing_up(3), 0.1},
                  {"cart-pole", testing::cartpole_swing_up(6), 0.1},
                  {"unicycle", testing::unicycle_parking(2), 0.1},
                  {"quadrotor", testing::quadrotor_move(0, 3), 1.2}};
  for (Case& c : cases) {
    SCOPED_TRACE(c.name);
    const auto problem = shared(std::move(c.problem));
    const Trajectory guess = testing::constant_controls(*problem, c.u);
    const double end = problem->times().back();
    Mpc mpc(problem, guess,
            {.horizon = end,
             .tick = problem->knot(0).dt,
             .iterations = std::nullopt,
             .hold = false,
             .solver_options = testing::tight_options()});
    const SolveResult plan = solve(*problem, "box_fddp", testing::tight_options(), guess);
    ASSERT_EQ(plan.status, SolveStatus::converged) << plan.message;
    const ClosedLoopResult loop = run_closed_loop(mpc, {.duration = end});
    ASSERT_EQ(static_cast<int>(loop.steps.size()), problem->knots());
    EXPECT_LT(distance(loop, plan.trajectory), 1e-6);
    EXPECT_NEAR(loop.cost, plan.cost, 1e-6 * std::abs(plan.cost));  // with the last node's cost
    for (const TickRecord& tick : loop.ticks) EXPECT_EQ(tick.outcome, TickOutcome::planned);
  }
}

TEST(ClosedLoop, FollowsItsFirstPlanThroughAnImpulse) {
  const auto problem = shared(testing::landing());
  const Trajectory guess = problem->create_trajectory();
  Mpc mpc(problem, guess,
          {.horizon = 1,
           .tick = 0.01,
           .iterations = std::nullopt,
           .hold = false,
           .solver_options = testing::tight_options()});
  const SolveResult plan = solve(*problem, "box_fddp", testing::tight_options(), guess);
  ASSERT_EQ(plan.status, SolveStatus::converged) << plan.message;
  const ClosedLoopResult loop = run_closed_loop(mpc, {.duration = 1});
  ASSERT_EQ(loop.steps.size(), 40u);  // the impulse is instantaneous
  for (int i = 0; i < problem->nx(); ++i) {
    EXPECT_NEAR(loop.steps[9].x[i], plan.trajectory.x(9)[i], 1e-6);
    EXPECT_NEAR(loop.steps[10].x[i], plan.trajectory.x(11)[i], 1e-6);
    EXPECT_NEAR(loop.last_state[i], plan.trajectory.x(41)[i], 1e-6);
  }
}

TEST(ClosedLoop, BalancesWithOneIterationATick) {
  const auto problem = testing::balanced_cartpole();
  for (const double tick : {0.05, 0.02, 0.03, 0.12}) {
    Mpc mpc(problem, problem->create_trajectory(),
            with_terminal(*problem, {.horizon = 1, .tick = tick}));
    const ClosedLoopResult loop =
        run_closed_loop(mpc, {.duration = 8, .step = {.integrator = Integrator::rk4, .dt = 0.01}});
    EXPECT_EQ(loop.end, LoopEnd::finished);
    EXPECT_NEAR(loop.last_state[0], 0, 1e-3) << tick;
    EXPECT_NEAR(loop.last_state[1], M_PI, 1e-3) << tick;
    for (const TickRecord& record : loop.ticks)
      EXPECT_EQ(record.outcome, TickOutcome::planned) << tick << ' ' << record.tick;
  }
}

/// States of a loop with one delay, starting after that time without control.
std::vector<std::vector<double>> states(const std::shared_ptr<const ShootingProblem>& problem,
                                        double delay, std::optional<int> iterations) {
  Mpc mpc(problem, problem->create_trajectory(),
          with_terminal(*problem, {.horizon = 1,
                                   .tick = 0.05,
                                   .iterations = iterations,
                                   .delay = delay,
                                   .solver_options = testing::tight()}));
  std::vector<std::vector<double>> x;
  for (const PlantStep& step : run_closed_loop(mpc, {.duration = 1.5}).steps) x.push_back(step.x);
  return x;
}

double largest_difference(const std::vector<std::vector<double>>& late,
                          const std::vector<std::vector<double>>& prompt) {
  double most = 0;
  for (std::size_t k = 1; k < late.size(); ++k)
    for (std::size_t i = 0; i < late[k].size(); ++i)
      most = std::max(most, std::abs(late[k][i] - prompt[k - 1][i]));
  return most;
}

TEST(ClosedLoop, PredictedDelayOnlyShiftsTheMotion) {
  const auto problem = testing::balanced_cartpole();
  for (const std::optional<int> iterations : {std::optional<int>(), std::optional<int>(2)}) {
    const auto late = states(problem, 0.05, iterations);
    const auto prompt = states(testing::balanced_cartpole(late[1]), 0, iterations);
    EXPECT_LT(largest_difference(late, prompt), 1e-7) << iterations.value_or(0);
  }
}

TEST(ClosedLoop, EndsWithTheTimeLineDespiteDelay) {
  const auto problem = testing::balanced_cartpole();  // 2 s
  Mpc mpc(problem, problem->create_trajectory(),
          {.horizon = 1, .tick = 0.05, .hold = false, .delay = 0.05});
  const ClosedLoopResult result = run_closed_loop(mpc, {.duration = 10});
  EXPECT_EQ(result.end, LoopEnd::finished);
  EXPECT_DOUBLE_EQ(result.end_time, 2);
  EXPECT_EQ(result.ticks.size(), 39u);
  EXPECT_EQ(result.steps.size(), 40u);
}

/// The cart-pole balancing at a given place.
std::shared_ptr<const ShootingProblem> balanced_at(double place) {
  return shared(testing::tracking_problem(
      cartpole({}), Integrator::rk4, 40, 0.05, {0.3, M_PI - 0.3, 0, 0},
      {{place, M_PI, 0, 0}, {1, 10, 0.1, 0.1}, {0.1}, {10, 100, 10, 10}}, -10, 10));
}

TEST(ClosedLoop, FollowsACommandOnlyFromItsTime) {
  const auto problem = balanced_at(0);
  const auto run = [&](std::vector<LoopCommand> commands) {
    Mpc mpc(problem, problem->create_trajectory(),
            {.horizon = 1.5, .tick = 0.05, .feedback_rate = 100});
    return run_closed_loop(mpc, {.duration = 8, .commands = std::move(commands)});
  };
  const ClosedLoopResult still = run({}), moved = run({{2, balanced_at(0.5)}});
  for (std::size_t i = 0; i < still.steps.size() && still.steps[i].time <= 2; ++i)
    EXPECT_EQ(moved.steps[i].x, still.steps[i].x) << i;
  EXPECT_NEAR(still.last_state[0], 0, 0.02);
  EXPECT_NEAR(moved.last_state[0], 0.5, 0.02);
}

TEST(ClosedLoop, CommandsMoveTheTerminalReferenceOfWindows) {
  const auto last_state = [](double place, std::vector<LoopCommand> commands) {
    const auto problem = balanced_at(place);
    Mpc mpc(problem, problem->create_trajectory(),
            with_terminal(*problem, {.horizon = 0.5, .tick = 0.05, .feedback_rate = 100}));
    return run_closed_loop(mpc, {.duration = 1, .commands = std::move(commands)}).last_state;
  };
  EXPECT_EQ(last_state(0, {{0, balanced_at(0.5)}}), last_state(0.5, {}));
  EXPECT_NE(last_state(0, {}), last_state(0.5, {}));
}

/// States of a cart-pole loop whose windows end on a path from `place`; a command at 1 s continues
/// the path from its current place.
std::vector<PlantStep> steps_along_path(double place) {
  const auto problem = shared(testing::tracking_problem(
      cartpole({}), Integrator::rk4, 160, 0.05, {place + 0.3, M_PI - 0.3, 0, 0},
      {{place, M_PI, 0, 0}, {1e-6, 10, 0.1, 0.1}, {0.1}, {10, 100, 10, 10}}, -10, 10));
  Trajectory guess = problem->create_trajectory();
  for (int k = 0; k <= problem->knots(); ++k) guess.x(k) << place + 0.3, M_PI - 0.3, 0, 0;
  const auto path = [place](double to) {
    return std::make_shared<StatePath>(
        StatePath{{0, 1, 2}, {{place, M_PI, 0, 0}, {place, M_PI, 0, 0}, {to, M_PI, 0, 0}}});
  };
  MpcOptions options =
      with_terminal(*problem, {.horizon = 0.5, .tick = 0.05, .feedback_rate = 100});
  options.terminal_path = path(place - 1);
  Mpc mpc(problem, guess, options);
  return run_closed_loop(mpc, {.duration = 6, .commands = {{1, problem, path(place + 1)}}}).steps;
}

TEST(ClosedLoop, FollowsThePathOfTheWindowEndNode) {
  const std::vector<PlantStep> here = steps_along_path(0), there = steps_along_path(5);
  EXPECT_NEAR(here.back().x[0], 1, 0.1);
  ASSERT_EQ(here.size(), there.size());
  for (std::size_t k = 0; k < here.size(); ++k) {
    EXPECT_NEAR(there[k].x[0] - 5, here[k].x[0], 1e-6) << k;
    for (int i = 1; i < 4; ++i) EXPECT_NEAR(there[k].x[i], here[k].x[i], 1e-6) << k;
  }
}

/// A plant that moves like a problem and whose contact is always closed.
class ClosedContact final : public PlantMotion {
 public:
  explicit ClosedContact(std::shared_ptr<const ShootingProblem> problem)
      : line_(std::move(problem), true), simulation_(line_, {}) {}
  double next_stop(double time) const override { return simulation_.next_stop(time); }
  void pass_instants(double time, double* x) override { simulation_.pass_instants(time, x); }
  void step(double time, double length, const double* u, double* x) override {
    simulation_.step(time, length, u, x);
  }
  std::uint32_t closed_contacts() const override { return 1; }

 private:
  TimeLine line_;
  Simulation simulation_;
};

// The contact of the knots from 0.5 s closes 0.1 s early; the command at 1.5 s moves with it.
TEST(ClosedLoop, RetimingMovesCommandsWithTheTimeLine) {
  const auto problem = balanced_at(0), commanded = balanced_at(0.5);
  Retiming retiming{.early = 0.12};
  for (int k = 0; k < problem->knots(); ++k) retiming.contacts.push_back(k < 10 ? 0 : 1);
  Mpc mpc(problem, problem->create_trajectory(),
          {.horizon = 1, .tick = 0.05, .retiming = retiming});
  std::vector<double> led;
  ClosedLoopOptions options{.duration = 2, .commands = {{1.5, commanded}}};
  options.plant = {{.motion = std::make_shared<ClosedContact>(problem)}};
  options.observe = [&](const Mpc& seen) {
    if (seen.time_line().numbers(0).parameters == commanded->knot(0).parameters)
      led.push_back(seen.last_tick().time);
  };
  run_closed_loop(mpc, options);
  ASSERT_FALSE(led.empty());
  EXPECT_NEAR(led.front(), 1.4, 1e-9);
}

// Four touch-downs, each 0.3 s early, end the time line of 2 s before the loop.
TEST(ClosedLoop, ContinuesIfRetimingEndsPhasesEarly) {
  const auto problem = balanced_at(0);
  Retiming retiming{.early = 0.3};
  for (int k = 0; k < problem->knots(); ++k) retiming.contacts.push_back(k / 5 % 2);
  Mpc mpc(problem, problem->create_trajectory(),
          {.horizon = 1, .tick = 0.05, .delay = 0.05, .retiming = retiming});
  ClosedLoopOptions options{.duration = 2};
  options.plant = {{.motion = std::make_shared<ClosedContact>(problem)}};
  const ClosedLoopResult result = run_closed_loop(mpc, options);
  EXPECT_EQ(result.end, LoopEnd::finished);
  EXPECT_DOUBLE_EQ(result.end_time, 2);
  EXPECT_EQ(result.ticks.size(), 40u);
  EXPECT_GT(result.ticks.back().time + result.ticks.back().shift, 2.5);
}

/// Offset of the controller's time line to the loop, tick by tick, if contacts close at a given
/// time. A phase of half a second without contacts precedes one with them.
std::vector<double> shifts(double closed_from, const Retiming& limits) {
  const auto problem = testing::balanced_cartpole();
  Retiming retiming = limits;
  for (int k = 0; k < problem->knots(); ++k) retiming.contacts.push_back(k < 10 ? 0 : 0b10);
  Mpc mpc(problem, problem->create_trajectory(),
          {.horizon = 1, .tick = 0.05, .retiming = retiming});
  std::vector<double> result;
  for (int tick = 0; tick < 16; ++tick) {
    mpc.see_contacts(is_before(mpc.time(), closed_from) ? 0b01 : 0b11);
    mpc.prepare();
    mpc.feedback(problem->initial_state());
    EXPECT_EQ(mpc.last_tick().outcome, TickOutcome::planned) << tick;
    result.push_back(std::round(1e3 * mpc.last_tick().shift) / 1e3);
  }
  return result;
}

TEST(ClosedLoop, PhasesBeginEarlierOnEarlyContactWithinLimits) {
  const std::vector<double> early = shifts(0.4, {.early = 0.12, .late = 0});
  EXPECT_EQ(early[7], 0);
  for (int tick = 8; tick < 16; ++tick) EXPECT_EQ(early[tick], 0.1) << tick;
  EXPECT_EQ(shifts(0.2, {.early = 0.12, .late = 0})[15], 0.1);  // the first tick within the limit
  EXPECT_EQ(shifts(0.2, {.early = 0, .late = 0}), std::vector<double>(16, 0));
}

TEST(ClosedLoop, EarlyStartMayUseTheWholeLimit) {
  for (const int ticks : {1, 2, 3, 4, 5, 6})
    EXPECT_EQ(shifts(0.2, {.early = 0.05 * ticks, .late = 0})[15], std::round(50 * ticks) / 1e3);
}

TEST(ClosedLoop, PhasesLastLongerOnLateContactWithinLimits) {
  const std::vector<double> late = shifts(0.6, {.early = 0, .late = 0.2});
  EXPECT_EQ(late[9], 0);
  EXPECT_EQ(late[10], -0.05);
  EXPECT_EQ(late[11], -0.1);
  for (int tick = 12; tick < 16; ++tick) EXPECT_EQ(late[tick], -0.1) << tick;
  EXPECT_EQ(shifts(5, {.early = 0, .late = 0.1})[15], -0.1);
  EXPECT_EQ(shifts(5, {.early = 0, .late = 0})[15], 0);
}

TEST(ClosedLoop, FeedbackBetweenTicksReducesTheError) {
  const auto problem = testing::balanced_cartpole();
  const auto cost = [&](std::optional<double> rate) {
    Mpc mpc(problem, problem->create_trajectory(),
            with_terminal(*problem, {.horizon = 1, .tick = 0.2, .feedback_rate = rate}));
    ClosedLoopOptions options{.duration = 4, .step = {.dt = 0.01}};
    options.jumps = {{.at = 1.03, .tangent = {0, 0, 0, 2}}};
    return run_closed_loop(mpc, options).cost;
  };
  EXPECT_LT(cost(100), cost(std::nullopt));
}

// Between nodes, a plan follows the model rather than a straight line.
TEST(ClosedLoop, FeedbackChangesNothingOnAPlannedMotion) {
  const auto problem = shared(testing::cartpole_swing_up(6));
  const double dt = problem->knot(0).dt, end = problem->times().back();
  const Trajectory guess = testing::constant_controls(*problem, 0.1);
  const SolveResult plan = solve(*problem, "box_fddp", testing::tight_options(), guess);
  Mpc mpc(problem, guess,
          {.horizon = end,
           .tick = end,
           .iterations = std::nullopt,
           .hold = false,
           .feedback_rate = 4 / dt,
           .solver_options = testing::tight_options()});
  const ClosedLoopResult loop = run_closed_loop(mpc, {.duration = end, .step = {.dt = dt / 4}});
  ASSERT_EQ(static_cast<int>(loop.steps.size()), 4 * problem->knots());
  double most = 0;
  for (std::size_t i = 0; i < loop.steps.size(); ++i)
    most = std::max(most,
                    std::abs(loop.steps[i].u[0] - plan.trajectory.u(static_cast<int>(i / 4))[0]));
  EXPECT_LT(most, 1e-2);
}

TEST(ClosedLoop, KeepsTheBoundsDuringTheFirstDelay) {
  const auto problem = testing::balanced_cartpole();
  Mpc mpc(problem, testing::constant_controls(*problem, 50),
          with_terminal(*problem, {.horizon = 1, .tick = 0.05, .delay = 0.05}));
  const ClosedLoopResult result = run_closed_loop(mpc, {.duration = 0.2});
  EXPECT_EQ(result.steps[0].u[0], 10);
  EXPECT_EQ(result.violation, 0);
}

TEST(ClosedLoop, KeepsKnotsOfItsPlanUnderSlowFeedback) {
  const auto problem = testing::balanced_cartpole();  // knots of 0.05 s
  const auto controls = [&](std::optional<double> rate) {
    Mpc mpc(problem, problem->create_trajectory(),
            with_terminal(*problem, {.horizon = 1,
                                     .tick = 0.2,
                                     .iterations = std::nullopt,
                                     .feedback_rate = rate,
                                     .solver_options = testing::tight()}));
    std::vector<double> u;
    for (const PlantStep& step : run_closed_loop(mpc, {.duration = 0.4}).steps)
      u.push_back(step.u[0]);
    return u;
  };
  const auto slow = controls(0.1), none = controls(std::nullopt);
  ASSERT_EQ(slow.size(), none.size());
  for (std::size_t k = 0; k < slow.size(); ++k) EXPECT_NEAR(slow[k], none[k], 1e-6) << k;
  EXPECT_GT(std::abs(none[1] - none[3]), 1e-3);
}

/// Tick outcomes of a loop in which something fails.
struct Trouble {
  std::shared_ptr<const ShootingProblem> problem = testing::balanced_cartpole();
  MpcOptions options = with_terminal(*problem, {.horizon = 1, .tick = 0.05});
  ClosedLoopOptions loop{.duration = 5};

  ClosedLoopResult run() const {
    Mpc mpc(problem, problem->create_trajectory(), options);
    return run_closed_loop(mpc, loop);
  }
};

void expect_balanced(const ClosedLoopResult& result) {
  EXPECT_EQ(result.end, LoopEnd::finished);
  EXPECT_NEAR(result.last_state[1], M_PI, 1e-2);
  for (const PlantStep& step : result.steps) EXPECT_TRUE(std::isfinite(step.u[0]));
}

TEST(ClosedLoop, KeepsItsPlanOnNonFiniteMeasurements) {
  Trouble trouble;
  trouble.loop.distort = [](int tick, std::vector<double>& x) {
    if (tick == 6 || tick == 7) x[1] = std::nan("");
  };
  const ClosedLoopResult result = trouble.run();
  expect_balanced(result);
  for (const TickRecord& tick : result.ticks) {
    const bool bad = tick.tick == 6 || tick.tick == 7;
    EXPECT_EQ(tick.outcome, bad ? TickOutcome::not_finite : TickOutcome::planned) << tick.tick;
  }
  EXPECT_NEAR(result.ticks[7].plan_age, 0.1, 1e-12);
  EXPECT_EQ(result.ticks[8].plan_age, 0);
}

TEST(ClosedLoop, FallsBackAfterConsecutiveLateTicks) {
  Trouble trouble;
  trouble.options.is_late = [](int tick) { return tick >= 40 && tick < 45; };
  trouble.options.fallback =
      HeldState{{0, M_PI, 0, 0}, Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Zero(1, 4)};
  const ClosedLoopResult result = trouble.run();
  expect_balanced(result);
  for (const TickRecord& tick : result.ticks) {
    const bool late = tick.tick >= 40 && tick.tick < 45;
    EXPECT_EQ(tick.outcome, late ? TickOutcome::late : TickOutcome::planned) << tick.tick;
    EXPECT_EQ(tick.fallback, tick.tick >= 42 && tick.tick < 45) << tick.tick;
  }
  EXPECT_EQ(result.steps[43].u[0], 0);
  EXPECT_NE(result.steps[45].u[0], 0);
}

/// A clock that advances by a given time in s per reading.
std::function<double()> clock_with(std::function<double()> step) {
  return [time = 0.0, step = std::move(step)]() mutable { return time += step(); };
}

TEST(ClosedLoop, CountsTicksAsLateByTheClock) {
  Trouble trouble;
  int reads = 0;  // four per tick, around preparation and feedback; three in the first
  trouble.options.clock = clock_with([&reads] {
    const int tick = ++reads / 4;
    return tick == 8 || tick == 9 ? 0.026 : 0.024;
  });
  const ClosedLoopResult result = trouble.run();
  expect_balanced(result);
  ASSERT_EQ(reads, 4 * 100 - 1);
  for (const TickRecord& tick : result.ticks)
    EXPECT_EQ(tick.outcome,
              tick.tick == 8 || tick.tick == 9 ? TickOutcome::late : TickOutcome::planned)
        << tick.tick;
  EXPECT_NEAR(result.ticks[9].plan_age, 0.1, 1e-12);
  EXPECT_EQ(result.ticks[10].plan_age, 0);
}

TEST(ClosedLoop, HasItsFirstPlanBeforeTheStart) {
  Trouble trouble;
  trouble.options.clock = clock_with([] { return 1.0; });
  const ClosedLoopResult result = trouble.run();
  for (const TickRecord& tick : result.ticks)
    EXPECT_EQ(tick.outcome, tick.tick == 0 ? TickOutcome::planned : TickOutcome::late) << tick.tick;
}

/// A mass that must stop at 0 with at most 0.6 m/s.
std::shared_ptr<const ShootingProblem> slow_mass() {
  const ShootingProblem free =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {1, 0},
                                {{0, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  return shared(
      testing::with_constraints(free, {{.name = "speed",
                                        .residual = coordinate_residual(free.manifold(), {1}),
                                        .reference = {0},
                                        .lower = {-0.6},
                                        .upper = {0.6},
                                        .first = 0,
                                        .last = 20}}));
}

/// Options of a loop that solves each window to tolerances.
MpcOptions to_tolerances(const ShootingProblem& problem, double horizon) {
  return with_terminal(problem, {.horizon = horizon,
                                 .tick = 0.1,
                                 .iterations = std::nullopt,
                                 .solver = "altro",
                                 .solver_options = {.max_iterations = 100}});
}

// The scale is a power of two, so loops agree in every digit.
TEST(ClosedLoop, IsIndependentOfCostUnits) {
  const auto run = [](const ShootingProblem& usual, MpcOptions options, double unit) {
    const auto problem = shared(scale_costs(usual, unit));
    Mpc mpc(problem, problem->create_trajectory(), with_terminal(*problem, std::move(options)));
    return run_closed_loop(mpc, {.duration = 2});
  };
  const auto mass = slow_mass(), cartpole = testing::balanced_cartpole();
  const struct {
    const ShootingProblem& problem;
    MpcOptions options;
  } cases[] = {{*mass, to_tolerances(*mass, 1)},
               {*mass, {.horizon = 1, .tick = 0.1, .iterations = 3, .solver = "altro"}},
               {*cartpole, {.horizon = 1, .tick = 0.05}}};
  for (const auto& [problem, options] : cases) {
    SCOPED_TRACE(options.solver);
    const ClosedLoopResult usual = run(problem, options, 1);
    for (const auto& [unit, farther] :
         {std::pair(std::exp2(-40), std::exp2(-60)), {std::exp2(30), std::exp2(50)}}) {
      const ClosedLoopResult other = run(problem, options, unit),
                             again = run(problem, options, farther);
      EXPECT_EQ(again.last_state, other.last_state) << unit;
      EXPECT_EQ(again.cost / farther, other.cost / unit) << unit;
      EXPECT_EQ(again.ticks[3].cost / farther, other.ticks[3].cost / unit) << unit;
      EXPECT_EQ(again.ticks[3].stationarity / farther, other.ticks[3].stationarity / unit);
      EXPECT_NEAR(other.cost / unit, usual.cost, 1e-3 * usual.cost);
      EXPECT_NEAR(other.ticks[3].cost / unit, usual.ticks[3].cost, 1e-3 * usual.ticks[3].cost);
      for (const TickRecord& tick : other.ticks) EXPECT_EQ(tick.outcome, TickOutcome::planned);
    }
  }
}

TEST(ClosedLoop, RecoversFromUnsatisfiableConstraints) {
  const auto problem = slow_mass();
  Mpc mpc(problem, problem->create_trajectory(), to_tolerances(*problem, 1));
  ClosedLoopOptions options{.duration = 4};
  options.distort = [](int tick, std::vector<double>& x) {
    if (tick == 5) x[1] = 20;
  };
  const ClosedLoopResult result = run_closed_loop(mpc, options);
  for (const TickRecord& tick : result.ticks)
    EXPECT_EQ(tick.outcome == TickOutcome::planned, tick.tick != 5)
        << tick.tick << ' ' << to_string(tick.outcome);
  for (std::size_t k = 10; k < result.steps.size(); ++k)
    EXPECT_LT(std::abs(result.steps[k].x[1]), 0.6 + 1e-5) << k;
  EXPECT_NEAR(result.last_state[0], 0, 0.05);
}

/// A mass that must be 5 m away at the end of each 1 s window, with at most 3 m/s².
std::shared_ptr<const ShootingProblem> far_goal() {
  const ShootingProblem free =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 80, 0.1, {0, 0},
                                {{5, 0}, {0.1, 1}, {0.1}, {1, 1}}, -3, 3);
  return shared(
      testing::with_constraints(free, {{.name = "goal",
                                        .residual = coordinate_residual(free.manifold(), {0}),
                                        .reference = {5},
                                        .lower = {0},
                                        .upper = {0},
                                        .first = 80,
                                        .last = 80}}));
}

TEST(ClosedLoop, AcceptsPlansThatMissAGoalByLess) {
  const auto problem = far_goal();
  const auto run = [&](bool late) {
    MpcOptions options = to_tolerances(*problem, 1);
    if (late) options.is_late = [](int) { return true; };
    Mpc mpc(problem, problem->create_trajectory(), options);
    return run_closed_loop(mpc, {.duration = 6});
  };
  const ClosedLoopResult result = run(false), kept = run(true);
  EXPECT_EQ(result.ticks.front().outcome, TickOutcome::improved);
  EXPECT_EQ(result.ticks.front().plan_age, 0);
  EXPECT_EQ(result.ticks.back().outcome, TickOutcome::planned);
  EXPECT_NEAR(result.last_state[0], 5, 0.05);
  EXPECT_EQ(kept.last_state[0], 0) << "the guess stays in force";
}

TEST(ClosedLoop, ImprovedFailingPlansStillLeadToTheFallback) {
  const auto problem = far_goal();
  MpcOptions options = to_tolerances(*problem, 1);
  options.fallback = HeldState{{0, 0}, Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Zero(1, 2)};
  options.fallback_after = 2;
  Mpc mpc(problem, problem->create_trajectory(), options);
  const ClosedLoopResult result = run_closed_loop(mpc, {.duration = 0.4});
  ASSERT_EQ(result.ticks.size(), 4u);
  EXPECT_EQ(result.ticks[0].outcome, TickOutcome::improved);
  EXPECT_FALSE(result.ticks[0].fallback);
  for (int tick = 1; tick < 4; ++tick) EXPECT_TRUE(result.ticks[tick].fallback) << tick;
  for (int tick = 2; tick < 4; ++tick)
    EXPECT_NE(result.ticks[tick].outcome, TickOutcome::improved) << "nothing is in force";
}

TEST(ClosedLoop, FallbackSettlesAtTheStateOfItsActivation) {
  Trouble trouble;
  std::vector<double> seen;
  trouble.options.is_late = [](int tick) { return tick >= 40; };
  Eigen::MatrixXd K(1, 4);
  K << 0.5, -20, 1, -4;
  trouble.options.fallback = HeldState{{0, M_PI, 0, 0},
                                       Eigen::VectorXd::Zero(1),
                                       Eigen::MatrixXd::Zero(1, 4),
                                       [&](const double* x, std::vector<double>& held) {
                                         seen.assign(x, x + 4);
                                         held[0] = x[0];
                                       }};
  trouble.options.fallback_after = 1;
  const ClosedLoopResult result = trouble.run();
  EXPECT_EQ(seen, result.steps[40].x);
}

TEST(ClosedLoop, StopsOnACondition) {
  Trouble trouble;
  auto model = std::make_shared<KnotModel>(cartpole({}), Integrator::none);
  model->add_constraint(make_constraint("upright", coordinate_residual(model->manifold(), {1}),
                                        ConstraintKind::bounds));
  trouble.loop.stop = StopCondition{model, {0, M_PI - 1, M_PI + 1, 1}};
  trouble.loop.jumps = {{.at = 2, .tangent = {0, 0, 0, 12}}};
  const ClosedLoopResult result = trouble.run();
  EXPECT_EQ(result.end, LoopEnd::stopped);
  EXPECT_GT(result.end_time, 2);
  EXPECT_LT(result.end_time, 2.5);
  EXPECT_GT(std::abs(result.last_state[1] - M_PI), 1);
}

TEST(ClosedLoop, EndsIfThePlantDiverges) {
  Trouble trouble;
  trouble.loop.jumps = {{.at = 1, .tangent = {0, 0, 0, 1e200}}};
  EXPECT_EQ(trouble.run().end, LoopEnd::diverged);
}

void expect_same(const ClosedLoopResult& a, const ClosedLoopResult& b) {
  ASSERT_EQ(a.steps.size(), b.steps.size());
  for (std::size_t k = 0; k < a.steps.size(); ++k) {
    EXPECT_EQ(a.steps[k].x, b.steps[k].x);
    EXPECT_EQ(a.steps[k].u, b.steps[k].u);
  }
}

TEST(ClosedLoop, IsReproducibleForAnyThreadCount) {
  Trouble trouble;
  trouble.loop.noise = MeasurementNoise{{1e-2, 1e-2, 1e-2, 1e-2}, 3};
  trouble.loop.duration = 2;
  const ClosedLoopResult once = trouble.run();
  expect_same(trouble.run(), once);
  trouble.options.solver_options.threads = 2;
  expect_same(trouble.run(), once);
  trouble.loop.noise->seed = 4;
  EXPECT_NE(trouble.run().last_state, once.last_state);
}

TEST(ClosedLoop, PlantMayDifferFromTheModel) {
  Trouble trouble;
  const auto model = trouble.run();
  trouble.loop.plant = {
      {0, shared(testing::tracking_problem(
              cartpole({.pole_mass = 0.4}), Integrator::rk4, 40, 0.05, {0.3, M_PI - 0.3, 0, 0},
              {{0, M_PI, 0, 0}, {1, 10, 0.1, 0.1}, {0.1}, {10, 100, 10, 10}}, -10, 10))}};
  const auto heavier = trouble.run();
  expect_balanced(heavier);
  EXPECT_NE(heavier.last_state, model.last_state);
}

TEST(ClosedLoop, ClipsControlsAtBoundsOfThePlantPeriod) {
  Trouble trouble;
  const auto with_bounds = [](double most) {
    return shared(testing::tracking_problem(
        cartpole({}), Integrator::rk4, 40, 0.05, {0.3, M_PI - 0.3, 0, 0},
        {{0, M_PI, 0, 0}, {1, 10, 0.1, 0.1}, {0.1}, {10, 100, 10, 10}}, -most, most));
  };
  constexpr double kChange = 0.5;
  trouble.loop.plant = {{0, with_bounds(3)}, {kChange, with_bounds(0.2)}};
  const auto result = trouble.run();
  double before = 0, after = 0;
  for (const PlantStep& step : result.steps) {
    double& largest = step.time < kChange - 1e-9 ? before : after;
    largest = std::max(largest, std::abs(step.u[0]));
  }
  EXPECT_EQ(before, 3);
  EXPECT_EQ(after, 0.2);
}

TEST(Mpc, ReportsUnsupportedOptions) {
  const auto problem = testing::balanced_cartpole();
  const Trajectory guess = problem->create_trajectory();
  const auto refused = [&](const MpcOptions& options) {
    EXPECT_THROW(Mpc(problem, guess, options), std::invalid_argument);
  };
  refused({.horizon = 0});
  refused({.horizon = 0.1, .tick = 0.2});
  refused({.iterations = 0});
  refused({.iterations = 1, .solver = "ipopt"});
  refused({.tick = 0.1, .delay = 0.2});
  refused({.feedback_rate = 0.0});
  refused({.fallback = HeldState{{0, 0}, Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Zero(1, 4)}});
  Retiming retiming;
  retiming.contacts.resize(problem->knots());
  refused({.hold = false, .retiming = retiming});
  Mpc mpc(problem, guess, {});
  EXPECT_THROW(mpc.feedback(std::vector<double>(4)), std::invalid_argument);
  mpc.prepare();
  EXPECT_THROW(mpc.feedback(std::vector<double>(3)), std::invalid_argument);
}

}  // namespace
}  // namespace conddp
