// Decisions of outer strategies, row by row of a hand-written log.
#include <gtest/gtest.h>

#include "solvers/constraints/outer_strategy.hpp"
#include "solvers/constraints/violation_slope.hpp"
#include "support/constrained_problems.hpp"

namespace conddp::testing {
namespace {

/// Two steps x⁺ = x + u from 0 with −1 ≤ u ≤ 1 that must end at 3, with terminal cost ½ weight (x −
/// 1)².
ShootingProblem steps_to_three(double weight, bool also_at_the_start = false) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem free =
      tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)), Integrator::discrete, 2,
                       1, {0}, {{1}, {0}, {0}, {weight}}, -1, 1);
  const auto state = state_residual(free.manifold());
  std::vector<Added> list = {{.name = "end",
                              .residual = state,
                              .reference = {0},
                              .lower = {3},
                              .upper = {3},
                              .first = 2,
                              .last = 2}};
  if (also_at_the_start)
    list.push_back({.name = "start",
                    .residual = state,
                    .reference = {0},
                    .lower = {0.5},
                    .upper = {9},
                    .first = 0,
                    .last = 0});
  return with_constraints(free, list);
}

SolverOptions growing_penalties(double stationarity = 1e-6) {
  SolverOptions options;
  options.augmented_lagrangian = {
      .initial_penalty = 4, .penalty_factor = 10, .max_penalty = 4e10, .sufficient_decrease = 0.25};
  options.tolerances.stationarity = stationarity;
  return options;
}

/// A strategy on the problem, at controls with simulated states.
struct Surrounded {
  template <class Make>
  Surrounded(ShootingProblem of, const SolverOptions& given, Make make)
      : problem(std::move(of)),
        options(given),
        bounds(problem),
        evaluator(problem),
        record(problem, options, true),
        iterate(problem, bounds, evaluator, recipe, options, record),
        strategy(make(*this)),
        row(problem.constraints().back().row) {
    record.begin();
    iterate.reset();
    strategy->start(nullptr);
    move_to(0, 0);
  }
  void move_to(double first, double second) {
    Trajectory& t = iterate.trajectory;
    t.u(0)[0] = first;
    t.u(1)[0] = second;
    t.x(1)[0] = first;
    t.x(2)[0] = first + second;
    iterate.differentiate(Feedback(problem), strategy->augmentation());
  }
  double penalty() const { return strategy->augmentation()->penalty[row]; }
  void measure() { strategy->measure(iterate, record.row); }
  bool update(const MeritModel& merit = {}, bool stuck = false) {
    return strategy->update(iterate, Feedback(problem), merit, stuck, record);
  }

  ShootingProblem problem;
  SolverOptions options;
  DdpRecipe recipe;
  ControlBounds bounds;
  Evaluator evaluator;
  SolveRecord record;
  Iterate iterate;
  std::unique_ptr<OuterStrategy> strategy;
  int row;  ///< of the last constraint
};

Surrounded augmented(const SolverOptions& options = growing_penalties(),
                     MultiplierSchedule schedule = MultiplierSchedule::always) {
  return {steps_to_three(0), options, [=](const Surrounded& at) {
            return augmented_lagrangian_strategy(at.problem, at.options, schedule);
          }};
}

/// With the penalty raised once, from 4 to 40, by two minimizations that miss by 3.
struct Grown : Surrounded {
  explicit Grown(const SolverOptions& given = growing_penalties())
      : Surrounded(steps_to_three(0), given, [](const Surrounded& at) {
          return augmented_lagrangian_strategy(at.problem, at.options, MultiplierSchedule::always);
        }) {
    for (int i = 0; i < 2; ++i) {
      measure();
      EXPECT_TRUE(update());
    }
    EXPECT_EQ(penalty(), 40);
    // A feasible log row and a minimization in progress.
    record.row.constraint = record.row.complementarity = 0;
    record.row.stationarity = 5e4;
    record.row.actual_decrease = 1e9;
  }
};

TEST(AugmentedStrategy, MinimizationEndsByStationarityOrSmallGain) {
  const Surrounded at = augmented();
  const auto done = [&](const IterationRecord& row) {
    return at.strategy->minimized(row, {.cost = -2});
  };
  EXPECT_TRUE(done({.stationarity = 0.1}));
  EXPECT_FALSE(done({.stationarity = 0.11}));
  EXPECT_TRUE(done({.iteration = 1, .stationarity = 1, .step = 0.2, .actual_decrease = 2e-3}));
  EXPECT_FALSE(done({.iteration = 1, .stationarity = 1, .step = 0.2, .actual_decrease = 2.1e-3}));
  EXPECT_FALSE(done({.iteration = 1, .stationarity = 1, .step = 0.19, .actual_decrease = 1e-3}));
  EXPECT_FALSE(done({.iteration = 0, .stationarity = 1, .step = 1, .actual_decrease = 1e-3}));
  // Gaps must be within tolerance or a hundredth of the violation.
  const double gap = at.options.tolerances.gap;
  EXPECT_TRUE(done({.gap = gap}));
  EXPECT_FALSE(done({.gap = 1.1 * gap}));
  EXPECT_TRUE(done({.gap = 0.01, .constraint = 1}));
  EXPECT_FALSE(done({.gap = 0.011, .constraint = 1}));
  EXPECT_FALSE(
      augmented(growing_penalties(), MultiplierSchedule::by_the_sweep).strategy->minimized({}, {}));
}

TEST(AugmentedStrategy, LaterMinimizationsAreTighter) {
  Surrounded at = augmented();
  const auto done = [&](const IterationRecord& row) {
    return at.strategy->minimized(row, {.cost = -2});
  };
  at.measure();
  at.record.row.iteration = 4;
  EXPECT_TRUE(at.update());
  EXPECT_EQ(at.record.row.outer, 1);
  EXPECT_TRUE(done({.iteration = 4, .stationarity = 0.01}));
  EXPECT_FALSE(done({.iteration = 4, .stationarity = 0.011}));
  EXPECT_TRUE(done({.iteration = 5, .stationarity = 1, .step = 1, .actual_decrease = 2e-4}));
  EXPECT_FALSE(done({.iteration = 5, .stationarity = 1, .step = 1, .actual_decrease = 2.1e-4}));
  EXPECT_FALSE(done({.iteration = 4, .stationarity = 1, .step = 1, .actual_decrease = 1e-4}));
  for (int i = 0; i < 5; ++i) {
    at.measure();
    at.record.row.stationarity = 1;
    at.record.row.actual_decrease = 1e9;
    EXPECT_TRUE(at.update());
  }
  EXPECT_EQ(at.record.row.outer, 6);
  // Steps are never required to gain less than 1e-8 of the cost.
  EXPECT_TRUE(done({.iteration = 5, .stationarity = 1, .step = 1, .actual_decrease = 2e-8}));
  EXPECT_FALSE(done({.iteration = 5, .stationarity = 1, .step = 1, .actual_decrease = 2.1e-8}));
}

// New multipliers gain ρ 3² = 36; a step may gain ten times that.
TEST(AugmentedStrategy, OnlyFinishedMinimizationsRaisePenalties) {
  struct Case {
    double stationarity, decrease, rounding, penalty;
  };
  for (const Case& c : {Case{0.01, 1e9, 0, 40},
                        {0.011, 1e9, 0, 4},
                        {5, 359, 0, 40},
                        {5, 361, 0, 4},
                        {5, 361, 36.2, 40}}) {
    Surrounded at = augmented();
    at.measure();
    EXPECT_EQ(at.record.row.constraint, 3);
    EXPECT_EQ(at.record.row.constraint_penalty, 4);
    EXPECT_TRUE(at.update());
    at.measure();
    at.record.row.stationarity = c.stationarity;
    at.record.row.actual_decrease = c.decrease;
    EXPECT_TRUE(at.update({.rounding = c.rounding}));
    EXPECT_EQ(at.penalty(), c.penalty) << c.stationarity << ' ' << c.decrease;
    EXPECT_NEAR((*at.strategy->multipliers())[at.row], -24, 1e-12);
    // The iterate's derivatives belong to the new function.
    Linearization fresh(at.problem);
    at.evaluator.differentiate(at.iterate.trajectory, fresh, at.strategy->augmentation());
    EXPECT_LT((fresh.knots[2].gradient - at.iterate.linearization.knots[2].gradient).norm(), 1e-9);
    EXPECT_LT((fresh.knots[2].hessian() - at.iterate.linearization.knots[2].hessian()).norm(),
              1e-9);
  }
}

TEST(AugmentedStrategy, PenaltiesFallIfRoundingHidesTheRest) {
  const auto after = [](double tolerance, bool stuck, double rounding, double violation) {
    Grown at(growing_penalties(tolerance));
    at.record.row.constraint = violation;
    EXPECT_TRUE(at.update({.rounding = rounding}, stuck));
    return at.penalty();
  };
  EXPECT_EQ(after(1e-6, true, 0, 0), 4) << "stuck";
  EXPECT_EQ(after(1e-6, true, 0, 1), 40) << "stuck, and violated";
  EXPECT_EQ(after(1e-6, false, 0, 0), 40);
  // Hidden decreases also speak against the penalty, which first grows to 400. The goal of this
  // minimization is 1e-3.
  EXPECT_EQ(after(1e-2, false, 1e9, 0), 40) << "at its last goal";
  EXPECT_EQ(after(1e-4, false, 1e9, 0), 400) << "on its way there";
  // A goal of a millionth of the tolerance is unattainable.
  EXPECT_EQ(after(1.1e3, false, 1e9, 0), 40);
  EXPECT_EQ(after(1.1e3, false, 0, 0), 4);
  EXPECT_EQ(after(0.9e3, false, 0, 0), 40);
}

TEST(AugmentedStrategy, PenaltiesFallTwentyTimesBeforeRoundingEnds) {
  Grown at;
  for (int i = 0; i < 20; ++i) EXPECT_TRUE(at.update({}, true)) << i;
  EXPECT_FALSE(at.update({}, true));
  EXPECT_EQ(at.record.result.status, SolveStatus::line_search_failed);
  EXPECT_EQ(at.record.result.failed_quantity, kRoundedCost);
  EXPECT_FALSE(at.iterate.linearized);
}

TEST(AugmentedStrategy, ViolationThatNoPenaltyLowersIsInfeasible) {
  Surrounded at = augmented();
  int updates = 0;
  bool goes_on = true;
  while (goes_on && updates < 20) {
    at.measure();
    goes_on = at.update();
    ++updates;
  }
  EXPECT_EQ(updates, 7);
  EXPECT_EQ(at.record.result.status, SolveStatus::infeasible);
  EXPECT_NE(at.record.result.message.find("'terminal/end'"), std::string::npos)
      << at.record.result.message;
}

TEST(AugmentedStrategy, RecoversTwentyTimesFromMinimizationsWithoutAStep) {
  Surrounded at = augmented();
  at.record.row.constraint = 1;
  for (const SolveStatus status : {SolveStatus::max_iterations, SolveStatus::time_limit}) {
    at.record.result.status = status;
    EXPECT_FALSE(at.strategy->recovers(at.record, true));
  }
  for (int i = 0; i < 20; ++i) {
    at.record.result.status =
        i % 2 == 0 ? SolveStatus::line_search_failed : SolveStatus::regularization_limit;
    EXPECT_TRUE(at.strategy->recovers(at.record, false)) << i;
  }
  EXPECT_FALSE(at.strategy->recovers(at.record, false));
  at.strategy->start(nullptr);
  EXPECT_TRUE(at.strategy->recovers(at.record, false)) << "in the next solve";
  // With satisfied constraints, only lower penalties help.
  at.record.row.constraint = 0;
  EXPECT_FALSE(at.strategy->recovers(at.record, false));
  EXPECT_FALSE(at.strategy->recovers(at.record, true)) << "the penalty is the first one";
  Grown grown;
  grown.record.result.status = SolveStatus::line_search_failed;
  EXPECT_TRUE(grown.strategy->recovers(grown.record, true));
  EXPECT_FALSE(grown.strategy->recovers(grown.record, false));
}

Surrounded least(double weight, bool also_at_the_start = false) {
  return {steps_to_three(weight, also_at_the_start), {}, [](const Surrounded& at) {
            return least_violation_strategy(at.problem, at.bounds, at.options);
          }};
}

// 20 · cost / 3², between 1 and a million.
TEST(LeastViolation, FirstPenaltiesWeighViolationTenTimesTheCost) {
  for (const auto& [weight, penalty] :
       {std::pair{0.0, 1.0}, {0.8, 1.0}, {2.0, 20 / 9.0}, {1e7, 1e6}}) {
    Surrounded at = least(weight);
    EXPECT_TRUE(at.strategy->fit(at.iterate));
    EXPECT_NEAR(at.penalty(), penalty, 1e-9 * penalty) << weight;
    at.measure();
    EXPECT_EQ(at.record.row.constraint, 3);
    EXPECT_EQ(at.record.row.constraint_knot, 2);
    EXPECT_EQ(at.record.row.constraint_penalty, at.penalty());
    EXPECT_NEAR((*at.strategy->multipliers())[at.row], -3 * penalty, 1e-9 * penalty);
  }
  Surrounded there = least(2);
  there.iterate.linearization.constraint.setConstant(3);
  EXPECT_FALSE(there.strategy->fit(there.iterate));
}

TEST(LeastViolation, IsSolvedAtAHundredthOfInitialViolation) {
  Surrounded at = least(0);
  at.strategy->fit(at.iterate);
  const auto solved_at = [&](double off, double gap) {
    at.iterate.linearization.constraint[at.row] = 3 - off;
    at.measure();
    at.record.row.gap = gap;
    return at.strategy->solved(at.record.row, at.options.tolerances, 0);
  };
  const double gap = at.options.tolerances.gap;
  EXPECT_TRUE(solved_at(0.03, gap));
  EXPECT_FALSE(solved_at(0.031, gap));
  EXPECT_FALSE(solved_at(0.03, 1.1 * gap));
}

// With u = (1, 1 − w), the end is 1 + w short, and controls can remove the share w / (1 + w).
TEST(LeastViolation, IsMinimizedOnceControlsAreNearlyExhausted) {
  Surrounded at = least(0);
  at.strategy->fit(at.iterate);
  const auto minimized_at = [&](double w, const IterationRecord& row) {
    at.move_to(1, 1 - w);
    at.measure();
    return at.strategy->minimized(row, {.cost = -2});
  };
  EXPECT_TRUE(minimized_at(0, {}));
  EXPECT_TRUE(minimized_at(5.0e-4, {}));
  EXPECT_FALSE(minimized_at(5.1e-4, {}));
  EXPECT_FALSE(minimized_at(0, {.gap = 1.1 * at.options.tolerances.gap}));
  EXPECT_TRUE(minimized_at(0.1, {.iteration = 1, .step = 0.2, .actual_decrease = 2e-7}));
  EXPECT_FALSE(minimized_at(0.1, {.iteration = 1, .step = 0.2, .actual_decrease = 2.1e-7}));
  EXPECT_FALSE(minimized_at(0.1, {.iteration = 1, .step = 0.19, .actual_decrease = 1e-7}));
  EXPECT_FALSE(minimized_at(0.1, {.iteration = 0, .step = 1, .actual_decrease = 1e-7}));
}

TEST(LeastViolation, ReportsInfeasibleOnceControlsAreExhausted) {
  // No control affects the violation of 'start': w (1 + w) / ((1 + w)² + 0.25) is 5e-3 between
  // these values.
  for (const double w : {6.2e-3, 6.4e-3}) {
    Surrounded at = least(0, true);
    at.strategy->fit(at.iterate);
    at.move_to(1, 1 - w);
    at.measure();
    at.record.row.iteration = 3;
    const double before = at.penalty();
    const bool goes_on = at.update();
    EXPECT_EQ(goes_on, w > 6.3e-3);
    EXPECT_EQ(at.penalty(), goes_on ? 100 * before : before);
    EXPECT_EQ(at.record.row.outer, goes_on ? 1 : 0);
    if (goes_on) {
      EXPECT_FALSE(
          at.strategy->minimized({.iteration = 3, .step = 1, .actual_decrease = 0}, {.cost = 1}))
          << "a minimization begins";
      continue;
    }
    EXPECT_EQ(at.record.result.status, SolveStatus::infeasible);
    EXPECT_NE(at.record.result.message.find(
                  "'terminal/end' by 1 (knot 2), 'start' by 0.5 (the initial state itself)"),
              std::string::npos)
        << at.record.result.message;
  }
}

TEST(LeastViolation, ContinuesWithOpenGapsToTheLargestPenalty) {
  Surrounded at = least(0);
  at.strategy->fit(at.iterate);
  at.move_to(1, 1);
  int updates = 0;
  bool goes_on = true;
  while (goes_on && updates < 20) {
    at.measure();
    at.record.row.gap = 1;
    at.record.result.status = SolveStatus::line_search_failed;
    EXPECT_EQ(at.strategy->recovers(at.record, false), at.penalty() < 1e12);
    goes_on = at.update();
    ++updates;
  }
  EXPECT_EQ(updates, 7);  // from 1 to 1e12
  EXPECT_EQ(at.record.result.status, SolveStatus::line_search_failed);
  EXPECT_FALSE(least(0).strategy->recovers(at.record, false) &&
               at.record.result.status != SolveStatus::line_search_failed);
  at.strategy->start(nullptr);
  EXPECT_EQ(at.penalty(), 1);
  at.record.result.status = SolveStatus::max_iterations;
  EXPECT_FALSE(at.strategy->recovers(at.record, false));
  at.record.result.status = SolveStatus::regularization_limit;
  EXPECT_TRUE(at.strategy->recovers(at.record, false));
}

// From 0.5 down to −1 along a slope of 2; along −3 without a bound, where the largest control is
// −5.
TEST(ViolationSlope, IsSlopeTimesControlRange) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const auto system = linear_system(one, one, Eigen::VectorXd::Zero(1));
  const TrackingCost cost{.goal = {0}, .q = {0}, .r = {0}, .qf = {0}};
  std::vector<Phase> phases;
  for (const auto& [lower, upper] : {std::pair{-1.0, 2.0}, {-7.0, kFree}, {-1.0, 2.0}})
    phases.push_back(tracking_phase(system, Integrator::discrete, 1, 1, cost, lower, upper));
  const ShootingProblem free({0}, std::move(phases), terminal_phase(system, cost));
  const ShootingProblem problem =
      with_constraints(free, {{.name = "end",
                               .residual = state_residual(free.manifold()),
                               .reference = {0},
                               .lower = {1},
                               .upper = {4},
                               .first = 3,
                               .last = 3},
                              {.name = "soft",
                               .residual = state_residual(free.manifold()),
                               .reference = {0},
                               .lower = {90},
                               .upper = {91},
                               .first = 1,
                               .last = 1,
                               .softness = Softness::l1,
                               .weight = 1}});
  const ControlBounds bounds(problem);
  ViolationSlope slope(problem, bounds);
  Eigen::VectorXd values = Eigen::VectorXd::Zero(problem.constraint_rows());
  int row = 0;
  for (const NodeConstraint& c : problem.constraints())
    if (!c.is_soft()) row = c.row;
  values[row] = 6;
  EXPECT_EQ(slope.violation(values), 2);
  EXPECT_EQ(slope.distances()[row], 2);
  values[row] = 0.5;
  EXPECT_EQ(slope.violation(values), 0.5);
  EXPECT_EQ(slope.distances()[row], -0.5);
  Trajectory t = problem.create_trajectory();
  t.u(0)[0] = 0.5;
  t.u(1)[0] = -5;
  t.u(2)[0] = 0.25;
  const auto share_of = [&](double a, double b, double c) {
    return slope.share(Eigen::Vector3d(a, b, c), t) * 0.25;
  };
  EXPECT_NEAR(share_of(2, 0, 0), 2 * 1.5, 1e-14);
  EXPECT_NEAR(share_of(-2, 0, 0), 2 * 1.5, 1e-14);
  EXPECT_NEAR(share_of(0, -3, 0), 3 * 5, 1e-14);
  EXPECT_NEAR(share_of(0, 3, 0), 3 * 2, 1e-14);
  EXPECT_NEAR(share_of(0, 0, -1), 1.75, 1e-14);
  EXPECT_NEAR(share_of(1, -1, 1), 1.5 + 5 + 1.25, 1e-14);
  t.u(0)[0] = -6;  // beyond its bound, and the largest
  EXPECT_NEAR(share_of(2, 0, 0), 0, 1e-14);
  EXPECT_NEAR(share_of(0, -3, 0), 3 * 6, 1e-14);
}

}  // namespace
}  // namespace conddp::testing
