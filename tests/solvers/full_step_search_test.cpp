#include "solvers/globalization/full_step_search.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/linear_quadratic.hpp"
#include "support/plain_pendulum.hpp"

namespace conddp::testing {
namespace {

/// An iterate with its direction, for trying a full step.
struct Tried {
  Tried(const ShootingProblem& given, const Trajectory& from,
        const SolverOptions::Tolerances& tolerances = {})
      : problem(given),
        bounds(problem),
        evaluator(problem),
        record(problem, options, false),
        iterate(problem, bounds, evaluator, recipe, options, record),
        direction(problem, bounds, {}),
        search(problem, bounds, tolerances) {
    record.begin();
    iterate.reset();
    search.reset();
    iterate.trajectory = iterate.before = from;
    iterate.differentiate(Feedback(problem), nullptr);
    EXPECT_EQ(direction.find(iterate.linearization, from, iterate.gaps, iterate.adjoint, {}), -1);
    merit.cost = iterate.linearization.total_cost();
    merit.slope = direction.step().slope();
    costates = iterate.adjoint.costates();
  }
  LineSearchResult run(const FullStepSearch::Goal& goal = {}) {
    return search.run(iterate, merit, direction, nullptr, goal);
  }

  const ShootingProblem& problem;
  SolverOptions options;
  DdpRecipe recipe{.open_gaps = true};
  ControlBounds bounds;
  Evaluator evaluator;
  SolveRecord record;
  Iterate iterate;
  Direction direction;
  FullStepSearch search;
  MeritModel merit;
  Eigen::MatrixXd costates;
};

/// A pendulum iterate without gaps, one or two steps before its optimum.
Trajectory near_optimum(const PlainPendulum& plain, const ShootingProblem& problem, double off) {
  Trajectory t = solve(problem, "ddp", {}, constant_controls(problem, 1)).trajectory;
  for (int k = 0; k < plain.knots; ++k) {
    t.u(k)[0] += off * (k % 2 == 0 ? 1 : -0.5);
    t.x(k + 1) = plain.next<double>(t.x(k), t.u(k)[0]);
  }
  return t;
}

/// Cost and gaps of a pendulum trajectory.
double cost_and_gaps(const PlainPendulum& plain, const Trajectory& t, Eigen::MatrixXd& gap) {
  gap.resize(2, plain.knots);
  double cost = plain.end_cost<double>(t.x(plain.knots));
  for (int k = 0; k < plain.knots; ++k) {
    const Eigen::Vector2d x = t.x(k);
    cost += plain.stage_cost<double>(x, t.u(k)[0]);
    gap.col(k) = plain.next<double>(x, t.u(k)[0]) - t.x(k + 1);
  }
  return cost;
}

TEST(FullStepSearch, RejectionDoublesFullStepsUntilDue) {
  const PlainPendulum plain;
  const ShootingProblem problem = plain.problem();
  Tried at(problem, near_optimum(plain, problem, 0.1));
  FullStepSearch& search = at.search;
  const auto steps_until_due = [&] {
    search.step_taken(false);
    for (int steps = 0; steps < 100; ++steps) {
      if (search.due()) return steps;
      search.step_taken(true);
    }
    return 100;
  };
  EXPECT_EQ(steps_until_due(), 1);
  at.run();
  search.reject();
  EXPECT_FALSE(search.due());
  search.step_taken(true);
  EXPECT_FALSE(search.due()) << "those before it count no more";
  EXPECT_EQ(steps_until_due(), 2);
  search.reject();
  EXPECT_EQ(steps_until_due(), 4);
  // A step that should be the last says nothing about earlier ones.
  at.iterate.trajectory = at.iterate.before;
  at.run({.last = true});
  search.reject();
  EXPECT_EQ(steps_until_due(), 4);
  search.reset();
  EXPECT_EQ(steps_until_due(), 1);
}

TEST(FullStepSearch, QuadraticMinimumGainsHalfOfTheSlope) {
  const LinearQuadratic lq(2, 3, {2, 1}, 3, -kFree, kFree, 1);
  const Trajectory optimum = lq.dense_optimum();
  for (const bool open : {false, true}) {
    Trajectory from = random_guess(*lq.problem, 3);
    from.x(0) = lq.x0;
    for (int k = 0; k < lq.N() && !open; ++k)
      from.x(k + 1) = lq.knots[k].A * from.x(k) + lq.knots[k].B * from.u(k) + lq.knots[k].c;
    Tried at(*lq.problem, from);
    // The costate cost of closing gaps is excluded from the step's decrease.
    const double closing =
        at.costates.rightCols(lq.N()).cwiseProduct(at.iterate.linearization.gap).sum();
    EXPECT_EQ(std::abs(closing) > 1, open);
    const LineSearchResult found = at.run();
    EXPECT_EQ(found.step, 1);
    EXPECT_EQ(found.trials, 1);
    for (int k = 0; k <= lq.N(); ++k)
      EXPECT_LT((at.iterate.trajectory.x(k) - optimum.x(k)).norm(), 1e-9) << k;
    EXPECT_NEAR(found.expected_decrease, closing - at.direction.step().slope(), 1e-8);
    EXPECT_NEAR(found.actual_decrease, lq.cost(from) + closing - lq.cost(optimum), 1e-8);
    if (open) continue;
    EXPECT_TRUE(found.accepted);
    EXPECT_NEAR(found.actual_decrease, 0.5 * found.expected_decrease, 1e-8);
  }
}

TEST(FullStepSearch, JudgesStepsWithTheCostOfClosingGaps) {
  const PlainPendulum plain;
  const ShootingProblem problem = plain.problem();
  const Trajectory from = near_optimum(plain, problem, 0.3);
  Tried at(problem, from);
  const LineSearchResult found = at.run();
  ASSERT_TRUE(found.accepted);
  EXPECT_FALSE(found.by_rounding);
  Eigen::MatrixXd gap;
  const double before = cost_and_gaps(plain, from, gap);
  const double after = cost_and_gaps(plain, at.iterate.trajectory, gap);
  EXPECT_GT(gap.norm(), 1e-6) << "negligible gaps stay";
  const double closing = at.costates.rightCols(plain.knots).cwiseProduct(gap).sum();
  EXPECT_NEAR(found.actual_decrease, before - after - closing, 1e-12);
  EXPECT_NEAR(found.expected_decrease, -at.direction.step().slope(), 1e-12);
  for (int k = 0; k <= plain.knots; ++k)
    EXPECT_LT((at.iterate.trajectory.x(k) - from.x(k) - at.direction.step().dx(k)).norm(), 1e-14);
  EXPECT_FALSE(at.iterate.linearized);
  EXPECT_FALSE(at.iterate.differentiated);
}

TEST(FullStepSearch, ClosesGapsIfRequested) {
  const PlainPendulum plain;
  const ShootingProblem problem = plain.problem();
  const Trajectory from = near_optimum(plain, problem, 0.3);
  for (const bool last : {false, true}) {
    Tried at(problem, from);
    const LineSearchResult found = at.run({.last = last, .close = !last});
    ASSERT_TRUE(found.accepted);
    Eigen::MatrixXd gap;
    const double before = cost_and_gaps(plain, from, gap);
    const double after = cost_and_gaps(plain, at.iterate.trajectory, gap);
    EXPECT_LE(gap.lpNorm<Eigen::Infinity>(), 1e-9);
    EXPECT_NEAR(found.actual_decrease, before - after, 1e-8);
    // Derivatives marked as available belong to the new iterate.
    if (!at.iterate.differentiated) continue;
    Linearization fresh(problem);
    at.evaluator.differentiate(at.iterate.trajectory, fresh);
    for (int k = 0; k <= plain.knots; ++k)
      EXPECT_EQ(at.iterate.linearization.knots[k].gradient, fresh.knots[k].gradient) << k;
  }
}

TEST(FullStepSearch, RejectsStepsShortOfSlopeOrWithGaps) {
  const PlainPendulum plain;
  const ShootingProblem problem = plain.problem();
  const Trajectory from = near_optimum(plain, problem, 0.3);
  for (const double promise : {4000.0, 6000.0}) {  // ½ is Armijo's share of 5000
    Tried at(problem, from);
    at.merit.slope *= promise;
    EXPECT_EQ(at.run().accepted, promise < 5000) << promise;
    EXPECT_EQ(at.iterate.linearized, promise > 5000)
        << "else derivatives are those of the step before";
  }
  for (const double tolerance : {1e-9, 1e-30}) {
    Tried at(problem, from, {.gap = tolerance});
    EXPECT_EQ(at.run({.last = true}).accepted, tolerance == 1e-9);
  }
}

TEST(FullStepSearch, RoundedDecreaseAcceptsUnchangedMerit) {
  const PlainPendulum plain;
  const ShootingProblem problem = plain.problem();
  const Trajectory from = near_optimum(plain, problem, 0.01);
  Tried at(problem, from);
  at.merit.rounding = 1;
  const LineSearchResult hidden = at.run();
  EXPECT_TRUE(hidden.accepted);
  EXPECT_TRUE(hidden.by_rounding);
  Tried worse(problem, from);
  worse.merit.rounding = 1;
  worse.merit.cost += 11;  // a change above ten roundings
  EXPECT_FALSE(worse.run().accepted);
}

}  // namespace
}  // namespace conddp::testing
