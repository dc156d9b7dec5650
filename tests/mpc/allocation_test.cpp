#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include "loop_cases.hpp"

// Sanitizers replace malloc.
#if !defined(__SANITIZE_ADDRESS__) && defined(__GLIBC__)

#include "support/allocation_count.hpp"

namespace conddp {
namespace {

/// Allocations of the ticks after the first ones, which create the workspaces of the windows.
long count(const std::shared_ptr<const ShootingProblem>& problem, const MpcOptions& options) {
  Mpc mpc(problem, problem->create_trajectory(), options);
  mpc.reserve(2);
  std::vector<double> x = problem->initial_state();
  const auto tick = [&] {
    mpc.prepare();
    mpc.feedback(x);
    x[0] *= 0.99;
  };
  for (int i = 0; i < 12; ++i) tick();
  allocations = 0;
  counting = true;
  for (int i = 0; i < 20; ++i) tick();
  counting = false;
  return allocations;
}

TEST(TickAllocation, IsZeroAfterTheFirstTicks) {
  const auto problem = testing::balanced_cartpole();
  for (const char* solver : {"box_fddp", "altro", "proxddp", "ipddp"})
    for (const double tick : {0.05, 0.02}) {
      const MpcOptions options = testing::with_terminal(
          *problem, {.horizon = 1, .tick = tick, .feedback_rate = 100, .solver = solver});
      EXPECT_EQ(count(problem, options), 0) << solver << ' ' << tick;
    }
}

TEST(TickAllocation, IsZeroWithSwingsStartingAtTheFeet) {
  const auto problem = testing::balanced_cartpole();
  MpcOptions options = testing::with_terminal(*problem, {.horizon = 1, .tick = 0.05});
  options.swings = {
      .feet = 1,
      .swings = {{.nodes = {10, 11, 12, 13}, .references = {1, 1, 1, 1}}},
      .find_feet = [](const double* x, double* places) { std::copy_n(x, 3, places); }};
  EXPECT_EQ(count(problem, options), 0);
}

}  // namespace
}  // namespace conddp

#endif
