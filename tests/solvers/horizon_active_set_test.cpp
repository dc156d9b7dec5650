#include <algorithm>
#include <tuple>

#include <gtest/gtest.h>

#include "solvers/stages/active_set.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/linear_quadratic.hpp"

namespace conddp::testing {
namespace {

/// Iterations to convergence.
int iterations(const LinearQuadratic& lq, const char* solver) {
  const SolveResult result = solve(*lq.problem, solver, {}, lq.problem->create_trajectory());
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_GT(result.log.back().clamped_controls, 0);
  return result.iterations;
}

TEST(ActiveSet, CountsChangesForAssumedSides) {
  const LinearQuadratic lq(1, 4, {3}, 2, -0.4, 0.3);
  ActiveSet set(*lq.problem);
  set.begin_sweep(true);
  EXPECT_EQ(set.changes(), 0);
  set.assume_sides(1, Eigen::Vector3d(-0.5, 0, 2));
  EXPECT_EQ(set.changes(), 2);
  set.assume_sides(1, Eigen::Vector3d(-1, 0, -1));
  EXPECT_EQ(set.changes(), 3) << "the third one goes to its other bound";
  for (const auto& [knot, entry, held] :
       {std::tuple{0, 0, false}, {1, 0, true}, {1, 1, false}, {1, 2, true}})
    EXPECT_EQ(set.holds(knot, entry), held) << knot << ' ' << entry;
  EXPECT_EQ(set.clamped_controls(), 2);
  set.begin_sweep(true);
  EXPECT_EQ(set.changes(), 0);
  EXPECT_EQ(set.clamped_controls(), 2);
}

TEST(ActiveSet, HoldsControlsPushedAgainstTheirBounds) {
  const LinearQuadratic lq(1, 4, {3}, 2, -0.4, 0.3);
  const ControlBounds bounds(*lq.problem);
  Trajectory trajectory = lq.problem->create_trajectory();
  trajectory.u(0) << -0.4, -0.4, 0.3;
  trajectory.u(1) << 0.3, 0.1, -0.4;
  Eigen::VectorXd gradient(6);
  gradient << 1, -1, -1, 1, 1, 0;
  ActiveSet set(*lq.problem);
  set.assume_sides(1, Eigen::Vector3d(1, 1, 1));
  set.assume_pushed_out(bounds, gradient, trajectory);
  for (const auto& [knot, entry, state] : {std::tuple{0, 0, BoundState::at_lower},
                                           {0, 1, BoundState::free},
                                           {0, 2, BoundState::at_upper},
                                           {1, 0, BoundState::free},
                                           {1, 1, BoundState::free},
                                           {1, 2, BoundState::free}})
    EXPECT_EQ(set.states(knot)[entry], state) << knot << ' ' << entry;
}

TEST(ActiveSet, HoldsControlsWithEqualBounds) {
  const LinearQuadratic lq(1, 4, {3}, 2, 0.2, 0.2);
  Trajectory trajectory = lq.problem->create_trajectory();
  for (int k = 0; k < 2; ++k) trajectory.u(k).setConstant(0.2);
  ActiveSet set(*lq.problem);
  set.assume_pushed_out(ControlBounds(*lq.problem), Eigen::VectorXd::Zero(6), trajectory);
  EXPECT_EQ(set.clamped_controls(), 6);
}

// Stages that consider only their own bounds would hold many controls of such a guess.
TEST(HorizonActiveSet, StepWithoutActiveBoundsTakesOneSweep) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    const LinearQuadratic free(seed, 4, {2, 3}, 12, -1e6, 1e6);
    const SolveResult answer =
        solve(*free.problem, "box_fddp", {}, free.problem->create_trajectory());
    double largest = 0;
    for (int k = 0; k < free.problem->knots(); ++k)
      largest = std::max(largest, answer.trajectory.u(k).cwiseAbs().maxCoeff());
    const LinearQuadratic lq(seed, 4, {2, 3}, 12, -1.01 * largest, 1.01 * largest);
    for (const char* solver : {"box_ddp", "box_fddp"}) {
      const SolveResult result = solve(*lq.problem, solver, {}, lq.problem->create_trajectory());
      ASSERT_EQ(result.status, SolveStatus::converged);
      EXPECT_EQ(result.log[1].sweeps, 1) << solver << ' ' << seed;
    }
  }
}

// A single stage cannot see the bounds that a step reaches at later knots; the horizon active set
// can. On a linear-quadratic problem, its step is the answer if that set is found.
TEST(HorizonActiveSet, MostBoxConstrainedProblemsTakeOneStep) {
  int one_step = 0;
  for (unsigned seed = 0; seed < 20; ++seed) {
    const LinearQuadratic lq(seed, 4, {2, 3}, 12, -0.4, 0.3);
    for (const char* solver : {"box_ddp", "box_fddp"}) one_step += iterations(lq, solver) <= 2;
  }
  EXPECT_GE(one_step, 30);
}

// Each revision of the horizon set adds a sweep.
TEST(HorizonActiveSet, SweepsAreCounted) {
  const LinearQuadratic lq(1, 4, {2, 3}, 12, -0.4, 0.3);
  const SolveResult result = solve(*lq.problem, "box_fddp", {}, lq.problem->create_trajectory());
  ASSERT_GT(result.iterations, 0);
  EXPECT_EQ(result.log.front().sweeps, 0);
  int most = 0;
  for (const IterationRecord& row : result.log) {
    EXPECT_GE(row.sweeps, std::min(row.iteration, 1));
    most = std::max(most, row.sweeps);
  }
  EXPECT_GT(most, 1);
}

// Active sets that do not settle within the sweep limit must not prevent convergence.
TEST(HorizonActiveSet, UnsettledSetsStillAllowConvergence) {
  for (unsigned seed = 0; seed < 20; ++seed)
    EXPECT_LE(iterations(LinearQuadratic(seed, 6, {4}, 20, -0.2, 0.2), "box_fddp"), 60) << seed;
}

}  // namespace
}  // namespace conddp::testing
