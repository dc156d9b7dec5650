// Stationarity reported by a solver with stiff gains holds along other gains too.
#include <gtest/gtest.h>

#include "analysis/certificate/lagrangian_gradient.hpp"
#include "analysis/comparison/benchmark.hpp"
#include "analysis/comparison/random_instance.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// Solves an example problem with proxddp from several initial states and checks the answers.
void expect_confirmed(const std::string& name, double size, std::vector<std::uint64_t> seeds) {
  Diagnostics out;
  const auto spec =
      read_problem(source_tree() / "problems" / (name + ".yaml"), {"solver.name=proxddp"}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  for (const std::uint64_t seed : seeds) {
    const ShootingProblem problem = perturb_initial_state(*built->problem, size, seed);
    const SolveResult result = solve(problem, "proxddp", spec->solver.options, built->guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << seed << ": " << result.message;
    const AnswerCheck check =
        check_answer(problem, result.trajectory, spec->solver.options.tolerances.constraint,
                     result.constraint_multipliers);
    EXPECT_LE(check.stationarity, 2 * spec->solver.options.tolerances.stationarity) << seed;
  }
}

TEST(ConfirmedStationarity, HoldsIfPenaltiesMakeGainsStiff) {
  expect_confirmed("unicycle_escape", 0.1, {2, 3, 4});
}

TEST(ConfirmedStationarity, IsReachedDespiteRoundingOfPenalties) {
  expect_confirmed("arm_maze", 0, {1});
}

// The gradient of the cost with respect to the controls alone, without gains, is also within
// tolerance unless the free motion amplifies it strongly. It was 7e-4 on quadruped_pace_turn.
TEST(ConfirmedStationarity, HoldsWithoutGains) {
  for (const char* name :
       {"acrobot_swingup", "arm_reach", "double_pendulum_swingup", "quadrotor_waypoints",
        "quadruped_jump", "quadruped_pace_turn", "quadruped_trot"}) {
    Diagnostics out;
    const auto spec = read_problem(source_tree() / "problems" / (std::string(name) + ".yaml"),
                                   {"solver.name=box_fddp"}, out);
    ASSERT_TRUE(spec) << format_diagnostics(out, false);
    const auto built = build_problem(*spec, {}, out);
    ASSERT_TRUE(built) << format_diagnostics(out, false);
    const ShootingProblem& problem = *built->problem;
    const SolveResult result = solve(problem, "box_fddp", spec->solver.options, built->guess);
    ASSERT_EQ(result.status, SolveStatus::converged) << name << ": " << result.message;
    const Eigen::MatrixXd closed = Eigen::MatrixXd::Zero(problem.ndx(), problem.knots());
    const AdjointPass pass =
        adjoint_pass(problem, node_derivatives(problem, result.trajectory, closed),
                     Eigen::VectorXd::Zero(problem.constraint_rows()), {});
    EXPECT_LE(pass.rounding, 1e-8) << name << ": nobody can tell";
    EXPECT_LE(project(problem, result.trajectory, pass.control).stationarity, 1e-6) << name;
  }
}

}  // namespace
}  // namespace conddp
