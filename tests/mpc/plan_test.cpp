// Trials of a plan on a window.
#include "mpc/plan.hpp"

#include <cmath>
#include <limits>

#include "loop_cases.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

TEST(PlanTrial, AnswerHasItsCost) {
  const auto problem = testing::balanced_cartpole();
  const SolveResult answer =
      solve(*problem, "box_fddp", testing::tight(), problem->create_trajectory());
  PlanTrial trial(*problem);
  const TrialFigures figures = trial.follow(answer.trajectory, answer.feedback);
  EXPECT_NEAR(figures.cost, answer.cost, 1e-9);
  EXPECT_EQ(figures.violation, 0);
}

TEST(PlanTrial, SimulatesAMotionWhateverThePlannedStates) {
  const auto problem = testing::balanced_cartpole();
  Trajectory plan = testing::constant_controls(*problem, 1), simulated = plan;
  for (int k = 0; k <= problem->knots(); ++k) plan.x(k).setConstant(7);
  Evaluator evaluator(*problem);
  evaluator.simulate(simulated);
  Evaluation expected(*problem);
  evaluator.evaluate(simulated, expected);
  PlanTrial trial(*problem);
  const TrialFigures figures = trial.follow(plan, Feedback(*problem));
  EXPECT_NEAR(figures.cost, expected.cost.sum(), 1e-9 * expected.cost.sum());
}

TEST(PlanTrial, HasTheLargestViolationOfAHardConstraint) {
  const ShootingProblem free =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 10, 0.1, {0, 0},
                                {{0, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  const ShootingProblem problem =
      testing::with_constraints(free, {{.name = "speed",
                                        .residual = coordinate_residual(free.manifold(), {1}),
                                        .reference = {0},
                                        .lower = {-0.6},
                                        .upper = {0.6},
                                        .first = 0,
                                        .last = 10}});
  PlanTrial trial(problem);
  // 2 m/s² for 1 s; controls beyond their bound of 3 m/s² are clamped to it.
  EXPECT_NEAR(trial.follow(testing::constant_controls(problem, 2), Feedback(problem)).violation,
              2 - 0.6, 1e-9);
  EXPECT_NEAR(trial.follow(testing::constant_controls(problem, 50), Feedback(problem)).violation,
              3 - 0.6, 1e-9);
}

TEST(PlanTrial, RanksPlansByViolationThenCost) {
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  EXPECT_TRUE(is_better({1, 9}, {2, 3}, 1e-6));
  EXPECT_FALSE(is_better({2, 3}, {1, 9}, 1e-6));
  EXPECT_TRUE(is_better({1 + 1e-7, 3}, {1, 9}, 1e-6));
  EXPECT_FALSE(is_better({1, 3}, {1, 3}, 1e-6));
  EXPECT_TRUE(is_better({5, 3}, {kInfinite, kInfinite}, 1e-6));
  EXPECT_FALSE(is_better({kInfinite, kInfinite}, {kInfinite, kInfinite}, 1e-6));
  EXPECT_FALSE(is_better({kInfinite, kInfinite}, {5, 3}, 1e-6));
}

}  // namespace
}  // namespace conddp
