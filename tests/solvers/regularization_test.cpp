#include "solvers/riccati/regularization.hpp"

#include <gtest/gtest.h>

#include "solvers/riccati/backward_sweep.hpp"
#include "solvers/stages/stage_solver.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

// Pitfall 18: a product never leaves zero.
TEST(RegularizationSchedule, LeavesZeroAndReturnsToIt) {
  RegularizationSchedule schedule;
  ASSERT_TRUE(schedule.increase());
  EXPECT_EQ(schedule.value(), 1e-6);
  ASSERT_TRUE(schedule.increase());
  EXPECT_GT(schedule.value(), 1e-6);
  for (int i = 0; i < 10 && schedule.value() > 0; ++i) schedule.decrease();
  EXPECT_EQ(schedule.value(), 0);
}

TEST(RegularizationSchedule, BeginsLowerOnRequest) {
  RegularizationSchedule schedule;
  schedule.lower_min(1e-9);
  schedule.lower_min(1e-7);
  ASSERT_TRUE(schedule.increase());
  EXPECT_EQ(schedule.value(), 1e-9);
}

TEST(RegularizationSchedule, GrowsFasterPerFailureUpToItsLimit) {
  constexpr double kLargest = SolverOptions::Regularization::kLargest;
  RegularizationSchedule schedule;
  ASSERT_TRUE(schedule.increase());
  double last = schedule.value(), last_ratio = 1;
  int steps = 1;
  while (schedule.increase()) {
    const double ratio = schedule.value() / last;
    if (schedule.value() == kLargest) break;
    EXPECT_GT(ratio, last_ratio);
    last_ratio = ratio;
    last = schedule.value();
    ++steps;
  }
  EXPECT_EQ(schedule.value(), kLargest);
  EXPECT_FALSE(schedule.increase());
  EXPECT_LE(steps, 12);
}

/// x⁺ = x + u with cost ½·weight·u²: Q_uu is weight, plus V_xx at the last knot.
ShootingProblem integrator_problem(double u_weight) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  return testing::tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)),
                                   Integrator::discrete, 3, 1, {1},
                                   {{0}, {1}, {u_weight}, {0.25}, false});
}

struct Swept {
  explicit Swept(const ShootingProblem& problem)
      : bounds(problem),
        evaluator(problem),
        linearization(problem),
        gaps(problem),
        trajectory(problem.create_trajectory()),
        sweep(problem, bounds),
        stages(unconstrained_stage(problem)),
        feedback(problem) {
    evaluator.differentiate(trajectory, linearization);
    gaps.set(linearization, true);
  }
  int run(double weight) {
    return sweep.run(linearization, trajectory, gaps, weight, *stages, feedback);
  }
  ControlBounds bounds;
  Evaluator evaluator;
  Linearization linearization;
  Gaps gaps;
  Trajectory trajectory;
  BackwardSweep sweep;
  std::unique_ptr<StageSolver> stages;
  Feedback feedback;
};

TEST(BackwardSweep, NamesTheKnotWithoutAMinimum) {
  const ShootingProblem problem = integrator_problem(1);
  Swept swept(problem);
  swept.linearization.knots[1].hessian.change()(1, 1) = -100;
  EXPECT_EQ(swept.run(0), 1);
  EXPECT_EQ(swept.run(10), 1);
  EXPECT_EQ(swept.run(200), -1);
}

// A weight of 3 adds a cost on the controls, the states, and the end, centered on the
// iterate, so gradients stay.
TEST(BackwardSweep, RegularizationCostsTheWholeStep) {
  const ShootingProblem problem = integrator_problem(1);
  Swept swept(problem), expected(problem);
  for (int k = 0; k <= problem.knots(); ++k) {
    auto& hessian = expected.linearization.knots[k].hessian.change();
    for (int i = 0; i < hessian.rows(); ++i) hessian(i, i) += 3;
  }
  ASSERT_EQ(expected.run(0), -1);
  ASSERT_EQ(swept.run(3), -1);
  for (int k = 0; k < problem.knots(); ++k) {
    EXPECT_NEAR(swept.feedback.K[k](0, 0), expected.feedback.K[k](0, 0), 1e-15) << k;
    EXPECT_NEAR(swept.feedback.k[k][0], expected.feedback.k[k][0], 1e-15) << k;
  }
  EXPECT_NEAR(swept.sweep.value(0).Vxx(0, 0), expected.sweep.value(0).Vxx(0, 0), 1e-14);
}

/// Gains that minimize nothing.
class FixedStage : public StageSolver {
 public:
  using StageSolver::StageSolver;
  bool solve(const StageProblem& /*stage*/, Eigen::Ref<Eigen::VectorXd> k,
             const LaneBlock& Kt) override {
    k.setConstant(0.1);
    Kt.view().setConstant(-0.4);
    return true;
  }
  bool minimizes_freely() const override { return false; }
};

// Pitfall 19: for any gains, the value is that of the policy u = ū + k + K δx.
TEST(BackwardSweep, ValueIsPolicyCostForNonOptimalGains) {
  const ShootingProblem problem = integrator_problem(0.5);
  Swept swept(problem);
  swept.stages = std::make_unique<FixedStage>(ActiveSet(problem));
  ASSERT_EQ(swept.evaluator.simulate(swept.trajectory), -1);
  swept.evaluator.differentiate(swept.trajectory, swept.linearization);
  ASSERT_EQ(swept.run(0), -1);
  const auto cost_of_policy = [&](double dx) {
    double x = swept.trajectory.x(0)[0] + dx, cost = 0;
    for (int k = 0; k < 3; ++k) {
      const double u = swept.trajectory.u(k)[0] + swept.feedback.k[k][0] +
                       swept.feedback.K[k](0, 0) * (x - swept.trajectory.x(k)[0]);
      cost += 0.5 * x * x + 0.25 * u * u;
      x += u;
    }
    return cost + 0.125 * x * x;
  };
  // The policy's cost is quadratic in δx: three values give its derivatives exactly.
  const double minus = cost_of_policy(-1), zero = cost_of_policy(0), plus = cost_of_policy(1);
  EXPECT_NEAR(swept.sweep.value(0).Vx[0], (plus - minus) / 2, 1e-12);
  EXPECT_NEAR(swept.sweep.value(0).Vxx(0, 0), plus - 2 * zero + minus, 1e-12);
}

TEST(BackwardSweep, ValueIsPolicyCostWithClampedControls) {
  const double bound = 0.2;
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem problem = testing::tracking_problem(
      linear_system(one, one, Eigen::VectorXd::Zero(1)), Integrator::discrete, 3, 1, {1},
      {{0}, {1}, {0.5}, {0.25}, false}, -bound, bound);
  Swept swept(problem);
  swept.stages = box_stage(problem);
  for (int k = 0; k < 3; ++k) swept.trajectory.u(k)[0] = 0.1;
  ASSERT_EQ(swept.evaluator.simulate(swept.trajectory), -1);
  swept.evaluator.differentiate(swept.trajectory, swept.linearization);
  ASSERT_EQ(swept.run(0), -1);
  EXPECT_GT(swept.stages->active_set().clamped_controls(), 0);
  EXPECT_EQ(swept.feedback.k[0][0], -bound - 0.1);
  EXPECT_EQ(swept.feedback.K[0](0, 0), 0);
  const auto cost_of_policy = [&](double dx) {
    double x = 1 + dx, cost = 0;
    for (int k = 0; k < 3; ++k) {
      const double u =
          0.1 + swept.feedback.k[k][0] + swept.feedback.K[k](0, 0) * (x - swept.trajectory.x(k)[0]);
      cost += 0.5 * x * x + 0.25 * u * u;
      x += u;
    }
    return cost + 0.125 * x * x;
  };
  const double minus = cost_of_policy(-1), zero = cost_of_policy(0), plus = cost_of_policy(1);
  EXPECT_NEAR(swept.sweep.value(0).Vx[0], (plus - minus) / 2, 1e-12);
  EXPECT_NEAR(swept.sweep.value(0).Vxx(0, 0), plus - 2 * zero + minus, 1e-12);
}

}  // namespace
}  // namespace conddp
