#include "mpc/time_line.hpp"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

#include "loop_cases.hpp"
#include "mpc/plan.hpp"
#include "mpc/window.hpp"
#include "mpc/window_count.hpp"

namespace conddp {
namespace {

using testing::shared;

std::vector<TimedKnot> cut(const TimeLine& line, double from, double to) {
  std::vector<TimedKnot> knots;
  line.cut(from, to, knots);
  return knots;
}

TEST(TimeLine, CutsKnotsAtWindowBoundaries) {
  const TimeLine line(shared(testing::pendulum_swing_up()), false);  // 50 knots of 0.06 s
  const auto knots = cut(line, 0.07, 0.2);
  ASSERT_EQ(knots.size(), 3u);
  EXPECT_EQ(knots[0].knot, 1);
  EXPECT_DOUBLE_EQ(knots[0].begin, 0.07);
  EXPECT_DOUBLE_EQ(knots[0].end, 0.12);
  EXPECT_EQ(knots[2].knot, 3);
  EXPECT_DOUBLE_EQ(knots[2].end, 0.2);
}

TEST(TimeLine, RoundedTimesCreateNoSliverKnots) {
  const TimeLine line(shared(testing::pendulum_swing_up()), false);
  for (int k = 0; k < 40; ++k) {
    const auto knots = cut(line, k * 0.06, (k + 10) * 0.06);
    ASSERT_EQ(knots.size(), 10u) << k;
    EXPECT_EQ(knots.front().knot, k);
  }
}

TEST(TimeLine, EndsOrHoldsItsLastKnot) {
  const auto problem = shared(testing::pendulum_swing_up());
  const TimeLine ending(problem, false), held(problem, true);
  EXPECT_EQ(cut(ending, 2.94, 3.2).size(), 1u);
  EXPECT_TRUE(cut(ending, 3, 3.2).empty());
  const auto knots = cut(held, 2.94, 3.15);
  ASSERT_EQ(knots.size(), 4u);
  for (const TimedKnot& knot : knots) EXPECT_EQ(knot.knot, 49);
  EXPECT_DOUBLE_EQ(knots[1].begin, 3);
  EXPECT_DOUBLE_EQ(knots[1].end, 3.06);
  EXPECT_DOUBLE_EQ(knots[3].end, 3.15);
  EXPECT_DOUBLE_EQ(held.at(3.15).begin, 3.12);
}

// Near 1e9 s, the rounding of times exceeds the tolerance for equal times.
TEST(TimeLine, IsCutAtItsEndHoweverLate) {
  const TimeLine held(shared(testing::pendulum_swing_up()), true);
  for (const double from : {1e9 + 0.01, 1e12, 1e17}) {
    const auto knots = cut(held, from, from + 64);
    ASSERT_FALSE(knots.empty());
    EXPECT_EQ(knots.front().begin, from);
    EXPECT_EQ(knots.back().end, from + 64);
    for (const TimedKnot& knot : knots) ASSERT_LT(knot.begin, knot.end);
  }
}

// The hopper is airborne for 0.1 s; an impulse at knot 10 then stops its foot.
TEST(TimeLine, IncludesInstantsAtTheWindowStart) {
  const TimeLine line(shared(testing::landing()), false);
  EXPECT_EQ(cut(line, 0.05, 0.1).size(), 5u);
  const auto later = cut(line, 0.1, 0.12);
  ASSERT_EQ(later.size(), 3u);
  EXPECT_EQ(later[0].knot, 10);
  EXPECT_DOUBLE_EQ(later[0].end, 0.1);
  EXPECT_EQ(later[1].knot, 11);
  EXPECT_EQ(line.at(0.1).knot, 11);
  EXPECT_EQ(line.instants_at(0.1), std::make_pair(10, 11));
  EXPECT_EQ(line.instants_at(0.105).first, line.instants_at(0.105).second);
}

TEST(TimeLine, AcceptsNumbersOfItsStructureOnly) {
  const auto problem = testing::balanced_cartpole();
  TimeLine line(problem, true);
  EXPECT_EQ(line.numbers(3).parameters, problem->knot(3).parameters);
  const auto other = testing::balanced_cartpole();
  line.take_numbers(other);
  EXPECT_EQ(line.numbers(3).parameters, other->knot(3).parameters);
  EXPECT_EQ(line.problem().knot(3).parameters, problem->knot(3).parameters);
  EXPECT_THROW(line.take_numbers(testing::shared(testing::pendulum_swing_up(3))),
               std::invalid_argument);
}

TEST(TimeLine, RejectsAFreeInitialState) {
  ShootingProblem whole = testing::pendulum_swing_up();
  std::vector<Phase> phases = whole.phases();
  phases.front().instant = true;
  EXPECT_THROW(
      TimeLine(shared(ShootingProblem(whole.initial_state(), phases, whole.terminal())), true),
      std::invalid_argument);
}

// With and without an inner impulse, cut in the middle of knots.
TEST(Window, FitsItsContextAndCut) {
  const SolverOptions options;
  for (const auto& problem : {testing::balanced_cartpole(), shared(testing::landing())}) {
    const TimeLine line(problem, true);
    const WindowContext context{line, 0.3, nullptr, "box_fddp", options};
    for (const double begin : {0.0, 0.05, 0.095, 0.3}) {
      WindowCut part;
      cut_window(context, begin, part);
      EXPECT_TRUE(Window(context, part).fits(context, part)) << problem->nx() << ' ' << begin;
    }
  }
}

// Windows of 1 s out of 2 s in knots of 0.05 s: whole knots, or one cut knot at each end.
TEST(WindowCount, CountsEachStructureOnce) {
  const auto count = [](double tick, bool hold) {
    return count_windows(testing::balanced_cartpole(),
                         {.horizon = 1, .tick = tick, .hold = hold, .solver = "box_fddp"}, 4);
  };
  EXPECT_EQ(count(0.05, true).structures, 2);  // of the phases, and of the held state behind them
  EXPECT_EQ(count(0.05, true).knots, 20);
  EXPECT_EQ(count(0.02, true).knots, 21);
  // Before the last second, the same windows; then each has its own length.
  EXPECT_EQ(count(0.05, false).structures, 1 + 20);
}

TEST(Plan, IsAFunctionOfTimeOnTheManifold) {
  const ShootingProblem problem = testing::quadrotor_move();
  Plan plan(problem);
  plan.times = problem.times();
  plan.trajectory.x(1) << 1, 0, 1, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0;  // rotated by π about z
  plan.trajectory.u(1).setConstant(2);
  std::vector<double> tangent(problem.ndx()), x(problem.nx());
  plan.state_at(0.02, false, tangent.data(), x.data());
  EXPECT_NEAR(x[5], std::sqrt(0.5), 1e-12);  // half the rotation, of unit length
  EXPECT_NEAR(x[6], std::sqrt(0.5), 1e-12);
  EXPECT_EQ(plan.knot_at(0.0399999), 0);
  EXPECT_EQ(plan.knot_at(0.04), 1);
  EXPECT_EQ(plan.knot_at(100), 49);
  EXPECT_EQ(plan.knot_at(-1), 0);
}

TEST(Plan, HasTwoStatesAtAnImpulse) {
  const ShootingProblem problem = testing::landing();
  Plan plan(problem);
  plan.times = problem.times();
  plan.trajectory.x(10).setConstant(1);
  plan.trajectory.x(11).setConstant(2);
  std::vector<double> tangent(problem.ndx()), x(problem.nx());
  plan.state_at(0.1, true, tangent.data(), x.data());
  EXPECT_EQ(x[0], 1);
  plan.state_at(0.1, false, tangent.data(), x.data());
  EXPECT_EQ(x[0], 2);
  EXPECT_EQ(plan.knot_at(0.1), 11);
}

}  // namespace
}  // namespace conddp
