// The previous control next to instantaneous knots: a free initial state, jumps, and impulses.
#include <fstream>

#include "analysis/derivatives/derivative_check.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// The controls follow p. With u₋₁ = 2 and one knot of 1 s, the cost is ½ (u − 2)² + ½ (u − p)².
/// Without a bound, u = p = 2 costs nothing; at the bound p = 1, u = 1.5 and the cost is 0.25.
constexpr std::string_view kChangeAfterChoice = R"(conddp: 1
parameters: {p: {free: true, lower: -1, upper: 1, start: 0}}
system: {states: [x], controls: [u], rate: {x: u}}
initial_state: {values: {x: 1}, previous_control: 2}
phases: [{choose: none}, {knots: 1, dt: 1}]
costs:
  change: {residual: control_rate}
  near: {residual: expression, rows: u - p}
solver: {name: altro, tolerances: {stationarity: 1.0e-9}}
)";

/// Two knots of 1 s around a jump: ½ (u₀ − 3)² + ½ (u₁ − u₀)² + ½ u₁² has its minimum at u = (2,
/// 1).
constexpr std::string_view kChangeOverJump = R"(conddp: 1
system: {states: [x], controls: [u], rate: {x: u}}
initial_state: {previous_control: 3}
phases: [{knots: 1, dt: 1}, {name: leap, jump: {x: -x}}, {knots: 1, dt: 1}]
costs:
  change: {residual: expression, rows: "u - previous[u]"}
  last: {residual: control, knots: [2]}
solver: {name: altro, tolerances: {stationarity: 1.0e-9}}
)";

constexpr const char* kSolversOfChanges[] = {"altro", "proxddp", "box_fddp", "ipopt"};

SolveResult answer_with_change(const Loaded& loaded, const char* solver) {
  return solve(*loaded.built->problem, solver, loaded.spec->solver.options, loaded.built->guess);
}

TEST(PreviousControl, PassesAnInitialStateChoice) {
  const Loaded loaded{std::string(kChangeAfterChoice)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const char* solver : kSolversOfChanges) {
    const SolveResult result = answer_with_change(loaded, solver);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << result.message;
    EXPECT_NEAR(result.trajectory.x(1)[1], 1, 1e-6) << solver << ": the parameter";
    EXPECT_NEAR(result.trajectory.x(1)[2], 2, 1e-6) << solver << ": the previous control";
    EXPECT_NEAR(result.trajectory.u(1)[0], 1.5, 1e-6) << solver;
    EXPECT_NEAR(result.cost, 0.25, 1e-6) << solver;
  }
}

TEST(PreviousControl, PassesAJump) {
  const Loaded loaded{std::string(kChangeOverJump)};
  ASSERT_TRUE(loaded.built) << loaded.all();
  for (const char* solver : kSolversOfChanges) {
    const SolveResult result = answer_with_change(loaded, solver);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << result.message;
    EXPECT_NEAR(result.trajectory.u(0)[0], 2, 1e-6) << solver;
    EXPECT_NEAR(result.trajectory.x(2)[1], 2, 1e-6) << solver << ": behind the jump";
    EXPECT_NEAR(result.trajectory.u(2)[0], 1, 1e-6) << solver;
  }
}

TEST(PreviousControl, IsPartOfTheGuessAfterInstantKnots) {
  for (const std::string_view text : {kChangeAfterChoice, kChangeOverJump}) {
    const Loaded loaded(replaced(text, "solver:",
                                 "initial_guess: {states: initial, controls: {constant: 0.5}}\n"
                                 "solver:"));
    ASSERT_TRUE(loaded.built) << loaded.all();
    const Trajectory& guess = loaded.built->guess;
    const bool jumps = text == kChangeOverJump;
    EXPECT_EQ(guess.x(1).tail(1)[0], jumps ? 0.5 : 2);
    EXPECT_EQ(guess.x(2).tail(1)[0], 0.5);
  }
}

void expect_derivatives_of_change(const Loaded& loaded) {
  for (const DerivativeComparison& derivative :
       check_derivatives(*loaded.built->problem, loaded.built->guess))
    EXPECT_LT(derivative.error, kDerivativeTolerance) << derivative.knot;
}

TEST(PreviousControl, HasDerivativesNextToInstantKnots) {
  for (const std::string_view text : {kChangeAfterChoice, kChangeOverJump}) {
    const Loaded loaded{std::string(text)};
    ASSERT_TRUE(loaded.built) << loaded.all();
    expect_derivatives_of_change(loaded);
  }
}

/// An example problem with a cost on the change of its controls.
Loaded example_with_change(const std::string& name) {
  std::ifstream file(kProblems / (name + ".yaml"));
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  return Loaded(text, {"costs.smooth={residual: control_rate, weight: 1.0e-3}"});
}

TEST(PreviousControl, PassesAnImpulse) {
  const Loaded loaded = example_with_change("hopper_jump");
  ASSERT_TRUE(loaded.built) << loaded.all();
  expect_derivatives_of_change(loaded);
  const SolveResult result = answer_with_change(loaded, "box_fddp");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const ShootingProblem& problem = *loaded.built->problem;
  const int controls = problem.terminal().model->step().tail();
  for (int k = 1; k < problem.knots(); ++k) {
    if (!problem.takes_no_time(k)) continue;
    const Eigen::VectorXd before = result.trajectory.x(k).tail(controls);
    EXPECT_LT((result.trajectory.x(k + 1).tail(controls) - before).norm(), 1e-6);
    EXPECT_LT((result.trajectory.u(k - 1) - before).norm(), 1e-6);
  }
}

TEST(PreviousControl, GoesWithContactImplicitSteps) {
  const Loaded loaded = example_with_change("finger_spinner");
  ASSERT_TRUE(loaded.built) << loaded.all();
  expect_derivatives_of_change(loaded);
  const SolveResult result = answer_with_change(loaded, "ipopt");
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  const ShootingProblem& problem = *loaded.built->problem;
  const int controls = problem.terminal().model->step().tail();
  ASSERT_GT(controls, 0);
  for (int k = 0; k < problem.knots(); ++k)
    EXPECT_LT((result.trajectory.x(k + 1).tail(controls) - result.trajectory.u(k).head(controls))
                  .lpNorm<Eigen::Infinity>(),
              1e-6)
        << k;
}

}  // namespace
}  // namespace conddp
