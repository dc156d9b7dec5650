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

}  // namespace
}  // namespace conddp
