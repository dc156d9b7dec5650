// Collocation as the integrator of a problem file.
#include <cmath>
#include <fstream>
#include <sstream>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/replay.hpp"
#include "analysis/derivatives/derivative_check.hpp"
#include "nlp/transcription.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "problem_file/plant/collocation_builder.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/nlp_derivatives.hpp"

namespace conddp {
namespace {

/// A pendulum swings up to rest in a given time with minimum effort, which is exact for constant
/// controls: only the error of the dynamics remains.
std::string swing_up(const std::string& integrator, int knots, const std::string& solver) {
  return "conddp: 1\nsystem: {type: pendulum}\ninitial_state: {values: {theta: 0}}\nintegrator: " +
         integrator + "\nphases:\n  - {name: swing, knots: " + std::to_string(knots) +
         ", duration: 2}\n"
         "costs: {effort: {residual: control}}\n"
         "constraints: {torque: {bounds: control, lower: -4, upper: 4}}\n"
         "terminal: {constraints: {up: {residual: state, reference: {values: {theta: 3.14159}}}}}\n"
         "initial_guess: {states: {keyframes: [{time: 2, state: {values: {theta: 3.14159}}}]}}\n"
         "solver: {name: " +
         solver +
         ", max_iterations: 1000, tolerances: {stationarity: 1.0e-9, constraint: 1.0e-9, gap: "
         "1.0e-9}}\n";
}

SolveResult solve(const Loaded& loaded) {
  return conddp::solve(*loaded.built->problem, *find_solver(loaded.spec->solver.name.value),
                       loaded.spec->solver.options, loaded.built->guess);
}

class CollocationProblem : public ::testing::TestWithParam<const char*> {};

TEST_P(CollocationProblem, HasTheSameOptimumWithAllItsSolvers) {
  std::vector<SolveResult> results;
  for (const char* solver : {"ipopt", "altro", "proxddp"}) {
    const Loaded loaded(swing_up(GetParam(), 20, solver));
    ASSERT_TRUE(loaded.built) << loaded.all();
    results.push_back(solve(loaded));
    EXPECT_EQ(results.back().status, SolveStatus::converged) << solver;
    EXPECT_NEAR(results.back().cost, results.front().cost, 1e-6 * results.front().cost) << solver;
  }
}

/// First derivatives by dual numbers, and Hessians by their differences, near the guess.
void expect_true_derivatives(const BuiltProblem& built) {
  std::mt19937_64 engine(2);
  for (const DerivativeComparison& c : check_derivatives(*built.problem, built.guess))
    EXPECT_LE(c.error, 1e-9) << static_cast<int>(c.kind) << " " << c.term;
  Evaluator evaluator(*built.problem);
  Transcription program(*built.problem, evaluator, {});
  const Eigen::VectorXd y = program.point_of(built.guess);
  testing::check_derivatives(program, y + 0.3 * testing::random_vector(y.size(), engine), engine,
                             1e-6);
}

TEST_P(CollocationProblem, DerivativesMatchDifferences) {
  const std::string collocation = std::string("integrator: ") + GetParam() + "\n";
  for (const std::string& text :
       {swing_up(GetParam(), 4, "ipopt"),
        std::string(kCartpole) + "solver: {name: ipopt}\n" + collocation}) {
    const Loaded loaded(text);
    ASSERT_TRUE(loaded.built) << loaded.all();
    expect_true_derivatives(*loaded.built);
  }
}

/// With a free duration, h is part of the state.
TEST_P(CollocationProblem, HasDerivativesWithRespectToFreeDurations) {
  const Loaded loaded(replaced(replaced(swing_up(GetParam(), 4, "ipopt"), "phases:\n",
                                        "phases:\n  - {name: start, choose: none}\n"),
                               "duration: 2}",
                               "duration: 2, free_duration: {lower: 0.5, upper: 4}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  expect_true_derivatives(*loaded.built);
}

TEST_P(CollocationProblem, IsAsFastAsTheForceAllows) {
  std::ifstream file(kProblems / "double_integrator_fastest.yaml");
  std::stringstream text;
  text << file.rdbuf();
  const Loaded loaded(
      replaced(text.str(), "integrator: rk2", std::string("integrator: ") + GetParam()));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve(loaded);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_NEAR(loaded.built->problem->times(result.trajectory).back(), std::sqrt(2.0), 1e-6);
}

TEST_P(CollocationProblem, GuessHasTheSlopesOfItsSolution) {
  const Loaded loaded(swing_up(GetParam(), 20, "ipopt"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve(loaded);
  Trajectory guess = result.trajectory;
  for (int k = 0; k < guess.knots(); ++k) guess.u(k).tail(guess.nu(k) - 1).setConstant(7);
  guess_slopes(*loaded.built->problem, guess);
  for (int k = 0; k < guess.knots(); ++k)
    EXPECT_LE((guess.u(k) - result.trajectory.u(k)).lpNorm<Eigen::Infinity>(), 1e-7) << k;
}

TEST_P(CollocationProblem, HasCostsOnActuatorsOnly) {
  const Loaded loaded(replaced(swing_up(GetParam(), 40, "ipopt"), "effort: {residual: control}",
                               "effort: {residual: control}, rate: {residual: control_rate}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(problem.nx(), 3);  // the last one is the previous torque
  EXPECT_EQ(loaded.built->state_columns.back().name, "previous/torque");
  expect_true_derivatives(*loaded.built);
  for (const CostTerm& cost : problem.knot(0).model->costs())
    EXPECT_EQ(cost.residual->size(), 1) << cost.name;
  const SolveResult result = solve(loaded);
  EXPECT_EQ(result.status, SolveStatus::converged);
  EXPECT_NEAR(result.trajectory.x(3)[2], result.trajectory.u(2)[0], 1e-9);
  // Includes feedback on the previous torque.
  EXPECT_LE(replay(problem, result.trajectory, result.feedback.K).feedback.deviation, 0.1);
}

TEST_P(CollocationProblem, IsRejectedBySolversWithoutEqualities) {
  Loaded loaded(replaced(swing_up(GetParam(), 5, "box_ddp"), "terminal:", "# terminal:"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_TRUE(usable_solvers(*loaded.built, loaded.diagnostics).empty());
  const std::string message = loaded.first_error();
  EXPECT_NE(message.find("'collocation'"), std::string::npos) << message;
  EXPECT_NE(message.find("altro, proxddp"), std::string::npos) << message;
}

INSTANTIATE_TEST_SUITE_P(Rules, CollocationProblem,
                         ::testing::Values("trapezoidal", "hermite_simpson"),
                         [](const auto& rule) { return std::string(rule.param); });

/// Both rules have order 4, so their optima on one control grid converge with order 4.
TEST(CollocationOptimum, ApproachesRungeKuttaWithOrderFour) {
  double off[2];
  for (const int half : {0, 1}) {
    const int knots = half == 0 ? 20 : 40;
    double cost[2];
    for (const int rule : {0, 1}) {
      const Loaded loaded(swing_up(rule == 0 ? "rk4" : "hermite_simpson", knots, "ipopt"));
      ASSERT_TRUE(loaded.built) << loaded.all();
      const SolveResult result = solve(loaded);
      ASSERT_EQ(result.status, SolveStatus::converged);
      cost[rule] = result.cost;
    }
    off[half] = std::abs(cost[1] - cost[0]);
  }
  EXPECT_GT(std::log2(off[0] / off[1]), 3) << off[0] << ", " << off[1];
}

/// The planned motion and the replay of its controls differ by an error of the rule's order.
TEST(CollocationOptimum, ReplayErrorHasItsOrder) {
  for (const auto& [integrator, order] :
       {std::pair{"trapezoidal", 2.0}, std::pair{"hermite_simpson", 4.0}}) {
    double off[2];
    for (const int half : {0, 1}) {
      const Loaded loaded(swing_up(integrator, half == 0 ? 40 : 80, "ipopt"));
      ASSERT_TRUE(loaded.built) << loaded.all();
      const SolveResult result = solve(loaded);
      const Replay played = replay(*loaded.built->problem, result.trajectory, result.feedback.K);
      ASSERT_EQ(played.impossible, "");
      off[half] = played.controls.deviation;
    }
    EXPECT_NEAR(std::log2(off[0] / off[1]), order, 0.4) << integrator << " " << off[1];
  }
}

/// Explicit rules would diverge even on the replay grid, which is ten times finer.
TEST(CollocationOptimum, IsReplayedOnAStiffSystem) {
  for (const char* integrator : {"trapezoidal", "hermite_simpson"}) {
    const Loaded loaded(replaced(swing_up(integrator, 20, "ipopt"), "type: pendulum",
                                 "type: pendulum, inertia: 1, damping: 1000, gravity: 0"));
    ASSERT_TRUE(loaded.built) << loaded.all();
    Trajectory plan = loaded.built->guess;
    for (int k = 0; k <= plan.knots(); ++k) plan.x(k).setZero();
    for (int k = 0; k < plan.knots(); ++k) plan.u(k)[0] = 4;
    const std::vector<Eigen::MatrixXd> gains(plan.knots(),
                                             Eigen::MatrixXd::Zero(plan.nu(0), plan.x(0).size()));
    const Replay played = replay(*loaded.built->problem, plan, gains);
    EXPECT_EQ(played.controls.lost_at, -1) << integrator;
    // Torque over damping for 2 s.
    EXPECT_NEAR(played.controls.final_state, 0.008, 1e-4) << integrator;
  }
}

}  // namespace
}  // namespace conddp
