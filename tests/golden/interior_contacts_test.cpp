// Contact-implicit examples by interior points in the sweep.
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

SolveResult solve_by(const char* solver, const testing::ReadyProblem& ready) {
  return solve(*ready.built.problem, solver, ready.spec.solver.options, ready.built.guess);
}

TEST(InteriorContacts, BlockSlidesAsFarAsItsForceAllows) {
  const testing::ReadyProblem ready("block_slope");
  const SolveResult own = solve_by("ipddp", ready), other = solve_by("ipopt", ready);
  ASSERT_EQ(own.status, SolveStatus::converged) << own.message;
  EXPECT_NEAR(own.cost, other.cost, 1e-6);
  EXPECT_LE(own.residuals.constraint, 1e-9);
}

TEST(InteriorContacts, CartMeetsItsWallsAtTheKnownOptimum) {
  const testing::ReadyProblem ready("cartpole_walls");
  const SolveResult own = solve_by("ipddp", ready), other = solve_by("ipopt", ready);
  ASSERT_EQ(own.status, SolveStatus::converged) << own.message;
  EXPECT_NEAR(own.cost, other.cost, 1e-6 * other.cost);
}

// A free start, a cycle, and hops whose contacts are found.
TEST(InteriorContacts, HopperFindsAPeriodicGait) {
  const testing::ReadyProblem ready("raibert_gait");
  const SolveResult own = solve_by("ipddp", ready);
  ASSERT_EQ(own.status, SolveStatus::converged) << own.message;
  EXPECT_LE(own.residuals.constraint, 1e-9) << "contacts, the cycle and the clearance are exact";
}

class StandingGuess : public ::testing::TestWithParam<const char*> {};

// Nothing in these guesses says when contacts open and close.
TEST_P(StandingGuess, SolvedThoughPerturbed) {
  const testing::ReadyProblem ready(GetParam(), {"perturbation.guess=0.05"});
  const SolveResult own = solve_by("ipddp", ready);
  ASSERT_EQ(own.status, SolveStatus::converged) << own.message;
  EXPECT_LE(own.residuals.constraint, 1e-6);
}

INSTANTIATE_TEST_SUITE_P(InteriorContacts, StandingGuess,
                         ::testing::Values("ball_rim", "fingers_turn_box", "push_pose",
                                           "solo_trot"),
                         [](const auto& name) { return std::string(name.param); });

}  // namespace
}  // namespace conddp
