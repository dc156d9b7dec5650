// Example problems by direct transcription: derivatives, and optima compared with known answers.
#include <set>

#include <fmt/format.h>

#include "analysis/comparison/random_instance.hpp"
#include "support/transcribed_problem.hpp"

namespace conddp {
namespace {

/// From their guesses, these reach a different local optimum than the DDP family.
const std::set<std::string> kOtherOptimum = {
    "arm_maze",       "car_parking",     "car_parking_goal",  "pendulum_cycle",
    "quadrotor_maze", "unicycle_escape", "unicycle_obstacles"};

class Transcribed : public ::testing::TestWithParam<std::string> {};

class TranscribedDerivatives : public ::testing::TestWithParam<std::string> {};

TEST_P(TranscribedDerivatives, MatchDifferences) { testing::check_transcription(GetParam()); }

TEST_P(Transcribed, HasTheKnownOptimum) {
  testing::expect_known_optimum(GetParam(), kOtherOptimum.count(GetParam()) > 0);
}

// Interior points in the sweep choose among the optima of contact-implicit problems themselves.
INSTANTIATE_TEST_SUITE_P(Ready, Transcribed,
                         ::testing::ValuesIn(testing::without("ipddp",
                                                              testing::ready_problems(false))),
                         testing::name_of);
INSTANTIATE_TEST_SUITE_P(Ready, TranscribedDerivatives,
                         ::testing::ValuesIn(testing::ready_problems(false)), testing::name_of);
INSTANTIATE_TEST_SUITE_P(Slow, TranscribedDerivatives,
                         ::testing::ValuesIn(testing::slow_problems()), testing::name_of);

/// From this initial state, exact Hessians throughout need more than 200 iterations.
TEST(TranscribedTrot, ConvergesFromAnotherStateInDozensOfIterations) {
  const testing::ReadyProblem ready("quadruped_trot",
                                    {"solver.name=ipopt", "solver.max_iterations=100"});
  const ShootingProblem problem = perturb_initial_state(*ready.built.problem, 0.1, 2);
  const SolveResult result = solve(problem, "ipopt", ready.spec.solver.options, ready.built.guess);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  const SolveResult ours = solve(problem, "box_fddp", ready.spec.solver.options, ready.built.guess);
  EXPECT_EQ(ours.status, SolveStatus::converged) << ours.message;
  EXPECT_NEAR(result.cost, ours.cost, 1e-6 * ours.cost);
}

/// Gauss-Newton Hessians come first if exact ones are expensive, unless contact-force constraints
/// or the file require exact ones.
TEST(TranscribedHessians, StartWithTheSuitableHessians) {
  const auto begins_exact = [](const std::string& name, const std::string& hessian) {
    const testing::ReadyProblem ready(
        name, {"solver.name=ipopt", "solver.hessian=" + hessian, "solver.max_iterations=1"});
    const SolveResult result =
        solve(*ready.built.problem, "ipopt", ready.spec.solver.options, ready.built.guess);
    return result.log.at(1).exact_hessian;
  };
  EXPECT_FALSE(begins_exact("quadruped_trot", "automatic"));
  EXPECT_TRUE(begins_exact("quadruped_trot", "exact"));
  EXPECT_TRUE(begins_exact("biped_step_cones", "automatic"));
  EXPECT_TRUE(begins_exact("arm_reach", "automatic"));
}

/// Ipopt's first answer is not good enough, so it continues to a better one.
TEST(TranscribedArm, UsesUpBudgetsThatEndBetweenTwoAnswers) {
  const testing::ReadyProblem ready("arm_fastest", {"solver.name=ipopt"});
  const auto run = [&](SolverOptions options) {
    return solve(*ready.built.problem, "ipopt", options, ready.built.guess);
  };
  SolverOptions options = ready.spec.solver.options;
  const SolveResult whole = run(options);
  ASSERT_EQ(whole.status, SolveStatus::converged) << whole.message;
  // Newton steps count as iterations; the budget applies to Ipopt.
  const int ipopt = whole.iterations - whole.log.back().newton;
  for (int budget = ipopt - 8; budget < ipopt; ++budget) {
    options.max_iterations = budget;
    const SolveResult result = run(options);
    EXPECT_EQ(result.status, SolveStatus::max_iterations) << result.message;
    EXPECT_EQ(result.iterations, budget);
  }
}

}  // namespace
}  // namespace conddp
