#include "solvers/iterate/control_curvature.hpp"

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/residuals/residuals.hpp"
#include "solvers/constraints/augmented_lagrangian.hpp"
#include "support/constrained_problems.hpp"
#include "support/small_problems.hpp"

namespace conddp::testing {
namespace {

/// A limit of −1 on a pendulum control, from the first knot to `last`.
Added limit_until(int last) {
  return {.name = "limit",
          .residual = control_residual(2, 1),
          .reference = {0},
          .lower = {-kFree},
          .upper = {-1},
          .first = 0,
          .last = last};
}

/// Weight 1e-3 and steps of 0.06 s, with a control limit that all knots violate.
constexpr double kCurvature = 6e-5;
ShootingProblem limited_pendulum() {
  return with_constraints(pendulum_swing_up(), {limit_until(49)});
}

SolverOptions first_penalty(double penalty) {
  SolverOptions options;
  options.augmented_lagrangian.initial_penalty = penalty;
  return options;
}

struct Linearized {
  ShootingProblem problem = limited_pendulum();
  AugmentedLagrangian constraints;
  Linearization linearization{problem};
  explicit Linearized(double penalty)
      : constraints(problem, first_penalty(penalty), MultiplierSchedule::always) {
    Evaluator(problem).differentiate(problem.create_trajectory(), linearization,
                                     &constraints.augmentation());
  }
};

TEST(ControlCurvature, MatchesTheCostsWithoutPenalties) {
  const Linearized at(10);
  EXPECT_NEAR(at.linearization.knots[3].hessian()(2, 2), 10 + kCurvature, 1e-9);
  EXPECT_NEAR(ControlCurvature(at.problem).least(at.linearization, &at.constraints.augmentation()) /
                  kCurvature,
              1, 1e-6);
}

// A single knot has no other knot to represent its curvature.
TEST(ControlCurvature, SingleKnotUsesItsOwnCosts) {
  const ShootingProblem free = tracking_problem(pendulum({}), Integrator::rk4, 1, 0.06, {0, 0},
                                                {{1, 0}, {1, 1}, {1e-3}, {1, 1}});
  const ShootingProblem problem = with_constraints(free, {limit_until(0)});
  const AugmentedLagrangian constraints(problem, first_penalty(10), MultiplierSchedule::always);
  Linearization linearization(problem);
  Evaluator(problem).differentiate(problem.create_trajectory(), linearization,
                                   &constraints.augmentation());
  ControlCurvature curvature(problem);
  EXPECT_NEAR(curvature.least(linearization, &constraints.augmentation()) / kCurvature, 1, 1e-6);
  EXPECT_NEAR(curvature.least(linearization, nullptr), 10 + kCurvature, 1e-9);
}

// Three knots; the last has the least curvature. Its shifted row is far inside, those of the others
// are outside, so nothing is removed from it.
TEST(ControlCurvature, RemovesContributionsOfOwnRows) {
  const auto system = pendulum({});
  std::vector<Phase> phases;
  for (const double weight : {3e-3, 2e-3, 1e-3})
    phases.push_back(tracking_phase(system, Integrator::rk4, 1, 0.06,
                                    {.goal = {1, 0}, .q = {1, 1}, .r = {weight}}, -kFree, kFree));
  const ShootingProblem free({0, 0}, std::move(phases),
                             terminal_phase(system, {.goal = {1, 0}, .qf = {1, 1}}));
  const ShootingProblem problem = with_constraints(free, {limit_until(2)});
  for (const double shift : {-5.0, 0.0}) {
    Augmentation augmentation(problem);
    augmentation.penalty.setConstant(10);
    augmentation.shift[2] = shift;
    Linearization linearization(problem);
    Evaluator(problem).differentiate(problem.create_trajectory(), linearization, &augmentation);
    EXPECT_NEAR(linearization.knots[2].hessian()(2, 2), kCurvature + (shift == 0 ? 10 : 0), 1e-9);
    EXPECT_NEAR(ControlCurvature(problem).least(linearization, &augmentation) / kCurvature, 1, 1e-6)
        << shift;
  }
}

TEST(AugmentedLagrangian, InitialPenaltiesMatchCostStiffness) {
  Linearized stiff(10), soft(0.1);
  EXPECT_TRUE(stiff.constraints.fit_to_costs(stiff.linearization));
  EXPECT_NEAR(stiff.constraints.largest_penalty() / (1e4 * kCurvature), 1, 1e-6);
  EXPECT_FALSE(soft.constraints.fit_to_costs(soft.linearization));
  EXPECT_EQ(soft.constraints.largest_penalty(), 0.1);
}

}  // namespace
}  // namespace conddp::testing
