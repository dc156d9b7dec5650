#include "solvers/restarts.hpp"

#include <cstdlib>
#include <stdexcept>

#include <gtest/gtest.h>

#include "support/small_problems.hpp"

namespace conddp {
namespace {

using testing::TrackingCost;

constexpr int kStarts = 7;

ShootingProblem double_integrator_move() {
  const TrackingCost cost{.goal = {1, 0}, .q = {1, 1}, .r = {1}, .qf = {1, 1}};
  return testing::tracking_problem(double_integrator(1), Integrator::semi_implicit_euler, 4, 0.1,
                                   {0, 0}, cost);
}

SolverOptions with_restarts(int seed, int threads = 1) {
  SolverOptions options;
  options.restarts = {.count = kStarts - 1, .seed = seed, .spread = 0.5};
  options.threads = threads;
  return options;
}

/// A solve that converges at a cost that its first control gives.
SolveResult ends_at(const ShootingProblem& problem, const Trajectory& start, double cost,
                    SolveStatus status = SolveStatus::converged) {
  SolveResult result(problem);
  result.trajectory = start;
  result.cost = cost;
  result.status = status;
  return result;
}

/// The start whose first control comes nearest to a target, so that targets tell starts apart.
Trajectory nearest(const ShootingProblem& problem, const SolverOptions& options, double target) {
  return best_start(problem, options, problem.create_trajectory(), [&](const Trajectory& start) {
    return ends_at(problem, start, std::abs(start.u(0)[0] - target));
  });
}

TEST(Restarts, ChooseTheStartThatEndsBest) {
  const ShootingProblem problem = double_integrator_move();
  for (int seed = 0; seed < 5; ++seed) {
    const SolverOptions options = with_restarts(seed);
    // The largest, the smallest, and what lies nearest to numbers between them.
    const double up = nearest(problem, options, 100).u(0)[0];
    const double low = nearest(problem, options, -100).u(0)[0];
    EXPECT_GT(up, 0) << seed;
    EXPECT_LT(low, 0) << seed;
    EXPECT_EQ(nearest(problem, options, 0).u(0)[0], 0) << "the guess itself, seed " << seed;
    for (const double target : {0.2, -0.2, 0.4}) {
      const double found = nearest(problem, options, target).u(0)[0];
      EXPECT_LE(std::abs(found - target), std::abs(0 - target)) << seed;
      EXPECT_LE(std::abs(found - target), std::abs(up - target)) << seed;
      EXPECT_LE(std::abs(found - target), std::abs(low - target)) << seed;
    }
  }
}

TEST(Restarts, GiveTheSameStartWithAnyNumberOfProcesses) {
  const ShootingProblem problem = double_integrator_move();
  const Trajectory one = nearest(problem, with_restarts(3), 100);
  const Trajectory three = nearest(problem, with_restarts(3, 3), 100);
  for (int k = 0; k < problem.knots(); ++k) {
    EXPECT_EQ(one.u(k), three.u(k)) << k;
    EXPECT_EQ(one.x(k + 1), three.x(k + 1)) << k;
  }
  EXPECT_NE(one.u(0)[0], nearest(problem, with_restarts(4), 100).u(0)[0]);
}

TEST(Restarts, LeaveTheInitialStateWhereItIs) {
  const ShootingProblem problem = double_integrator_move();
  const Trajectory start = nearest(problem, with_restarts(1), 100);
  EXPECT_EQ(start.x(0), problem.create_trajectory().x(0));
  EXPECT_NE(start.x(1), problem.create_trajectory().x(1));
}

TEST(Restarts, TakeNoStartThatFailsHoweverLowItsCost) {
  const ShootingProblem problem = double_integrator_move();
  const SolverOptions options = with_restarts(2);
  const Trajectory guess = problem.create_trajectory();
  const Trajectory start = best_start(problem, options, guess, [&](const Trajectory& t) {
    return t.u(0)[0] > 0 ? ends_at(problem, t, -t.u(0)[0], SolveStatus::max_iterations)
                         : ends_at(problem, t, t.u(0)[0]);
  });
  EXPECT_EQ(start.u(0)[0], nearest(problem, options, -100).u(0)[0]);
}

TEST(Restarts, OutliveAProcessThatDies) {
  const ShootingProblem problem = double_integrator_move();
  const SolverOptions options = with_restarts(2);
  const Trajectory start =
      best_start(problem, options, problem.create_trajectory(), [&](const Trajectory& t) {
        if (t.u(0)[0] > 0) std::_Exit(3);
        if (t.u(0)[0] == 0) throw std::runtime_error("no answer");
        return ends_at(problem, t, -t.u(0)[0]);
      });
  EXPECT_LT(start.u(0)[0], 0);
}

}  // namespace
}  // namespace conddp
