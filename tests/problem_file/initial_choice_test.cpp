#include <gtest/gtest.h>

#include "analysis/derivatives/derivative_check.hpp"
#include "ocp/evaluation/evaluator.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

/// The small pendulum with a chosen initial state.
std::string choosing(const std::string& choice, const std::string& terminal = "") {
  std::string text = replaced(kPendulum, "name: box_ddp", "name: altro");
  text = replaced(text, "phases:\n", "phases:\n  - " + choice + "\n");
  if (!terminal.empty())
    text = replaced(text, "terminal:\n", "terminal:\n  constraints:\n    " + terminal + "\n");
  return text;
}

const std::string kFloating = R"(conddp: 1
robot:
  urdf: robots/free_body.urdf
  base: floating
  actuation: {thrusters: [{name: a, frame: body}, {name: b, frame: body, direction: [1, 2, 3]}]}
initial_state: {base: {position: [1, 2, 3], rpy: [0.3, -0.2, 0.5]}}
phases:
  - {name: start, choose: all}
  - {knots: 3, dt: 0.1}
costs: {effort: {residual: control}}
terminal:
  costs: {near: {residual: cycle, offset: {"base/x": 0.5, "base/z": -0.2}}}
  constraints: {cycle: {residual: cycle, offset: {"base/x": 0.5}}}
solver: {name: altro}
)";

TEST(InitialChoice, IsAKnotWithoutTime) {
  const Loaded loaded(choosing("{name: start, choose: omega, lower: -2, upper: {omega: 3}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(problem.knots(), 11);
  EXPECT_EQ(problem.nu(0), 1);
  EXPECT_EQ(problem.nx(), 2) << "nothing is remembered where nothing asks for it";
  EXPECT_EQ(problem.times()[0], 0);
  EXPECT_EQ(problem.times()[1], 0);
  EXPECT_EQ(problem.times()[2], 0.1);
  EXPECT_TRUE(problem.takes_no_time(0));
  EXPECT_FALSE(problem.takes_no_time(1));
  EXPECT_EQ(problem.knot(0).model->control_lower()[0], -2);
  EXPECT_EQ(problem.knot(0).model->control_upper()[0], 3);
  Trajectory t = problem.create_trajectory();
  t.u(0)[0] = 1.5;
  Evaluator evaluator(problem);
  ASSERT_EQ(evaluator.simulate(t), -1);
  EXPECT_DOUBLE_EQ(t.x(1)[0], 0.1);
  EXPECT_DOUBLE_EQ(t.x(1)[1], 1.5);
}

TEST(InitialChoice, MovesAPoseAlongItsTangent) {
  const Loaded loaded(kFloating);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  EXPECT_EQ(problem.nu(0), 12);
  EXPECT_EQ(problem.nx(), 13 + 12);
  Trajectory t = problem.create_trajectory();
  for (int i = 0; i < 12; ++i) t.u(0)[i] = 0.1 * (i + 1);
  Evaluator evaluator(problem);
  ASSERT_EQ(evaluator.simulate(t), -1);
  std::vector<double> expected(problem.nx());
  Eigen::VectorXd tangent = Eigen::VectorXd::Zero(problem.ndx());
  tangent.head(12) = t.u(0);
  tangent.tail(12) = t.u(0);
  problem.manifold().integrate(problem.initial_state().data(), tangent.data(), expected.data());
  for (int i = 0; i < problem.nx(); ++i) EXPECT_NEAR(t.x(1)[i], expected[i], 1e-14) << i;
  EXPECT_EQ(t.x(4).tail(12), t.u(0)) << "it is remembered";

  // The cycle measures from the chosen state, displaced in the world.
  std::copy_n(t.x(1).data(), problem.nx(), t.x(4).data());
  t.x(4)[0] += 0.5;
  Evaluation evaluation(problem);
  evaluator.evaluate(t, evaluation);
  EXPECT_LT(evaluation.constraint.tail(12).cwiseAbs().maxCoeff(), 1e-14);
  EXPECT_NEAR(evaluation.cost[4], 0.5 * 0.2 * 0.2, 1e-12);
}

TEST(InitialChoice, DerivativesMatchDualNumbers) {
  for (const std::string& text :
       {kFloating, choosing("{choose: all}", "cycle: {residual: cycle, offset: [1, 2]}")}) {
    const Loaded loaded(text);
    ASSERT_TRUE(loaded.built) << loaded.all();
    const auto list = check_derivatives(*loaded.built->problem, loaded.built->guess);
    int constraints = 0;
    for (const DerivativeComparison& c : list) {
      EXPECT_LT(c.error, 1e-9) << "phase " << c.phase << ", row " << c.row << ", column "
                               << c.column;
      constraints += c.kind == DerivativeKind::constraint;
    }
    EXPECT_GE(constraints, 1);
  }
}

TEST(InitialChoice, IsGuessedFromTheStateGuess) {
  const Loaded loaded(choosing("{choose: all, upper: {omega: 1}}") +
                      "initial_guess: {states: {keyframes: [{time: 0, state: [0.5, 4]}, "
                      "{time: 0.7, state: [1, 0]}]}}\n");
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_DOUBLE_EQ(loaded.built->guess.u(0)[0], 0.4);
  EXPECT_DOUBLE_EQ(loaded.built->guess.u(0)[1], 1) << "no further than it may";
  EXPECT_DOUBLE_EQ(loaded.built->guess.x(1)[1], 4);
}

TEST(InitialChoice, FirstStateConstraintsHoldAtTheNextKnot) {
  const Loaded loaded(
      replaced(choosing("{choose: all}"), "constraints:\n",
               "constraints:\n  fast: {residual: state, columns: omega, lower: 2, knots: [1]}\n"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  ASSERT_EQ(loaded.built->problem->constraints().size(), 1u);
  EXPECT_EQ(loaded.built->problem->constraints()[0].node, 1);
}

/// No given initial state improves on the optimal one.
TEST(InitialChoice, IsOptimal) {
  for (const char* solver : {"box_ddp", "box_fddp", "altro", "proxddp", "ipopt"}) {
    const Loaded free(choosing("{choose: omega, lower: -9, upper: 9}"));
    ASSERT_TRUE(free.built) << free.all();
    const SolveResult best = solve(*free.built->problem, solver, {}, free.built->guess);
    ASSERT_EQ(best.status, SolveStatus::converged) << solver << ": " << best.message;
    const double omega = best.trajectory.x(1)[1];
    EXPECT_GT(std::abs(omega), 0.1);
    for (const double change : {0.0, -0.05, 0.05}) {
      const Loaded fixed(replaced(kPendulum, "{theta: 0.1}",
                                  "{theta: 0.1, omega: " + std::to_string(omega + change) + "}"));
      const SolveResult other = solve(*fixed.built->problem, solver, {}, fixed.built->guess);
      ASSERT_EQ(other.status, SolveStatus::converged) << other.message;
      if (change == 0)
        EXPECT_NEAR(other.cost, best.cost, 1e-6 * best.cost) << solver;
      else
        EXPECT_GT(other.cost, best.cost * (1 + 1e-6)) << solver;
    }
  }
}

TEST(InitialChoice, CycleEndsAtItsStart) {
  for (const char* solver : {"altro", "proxddp", "ipopt"}) {
    Loaded loaded(
        replaced(choosing("{choose: all}", "cycle: {residual: cycle, offset: {theta: 0.3}}"),
                 "goal: {residual: state, reference: {values: {theta: 1}}, weight: 10}",
                 "goal: {residual: state, columns: omega, reference: 2, weight: 10}"));
    ASSERT_TRUE(loaded.built) << loaded.all();
    SolverOptions options;
    options.tolerances.constraint = 1e-9;
    const SolveResult result = solve(*loaded.built->problem, solver, options, loaded.built->guess);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_NEAR(result.trajectory.x(11)[0], result.trajectory.x(1)[0] + 0.3, 1e-8) << solver;
    EXPECT_NEAR(result.trajectory.x(11)[1], result.trajectory.x(1)[1], 1e-8) << solver;
    EXPECT_GT(result.trajectory.u(0).cwiseAbs().maxCoeff(), 1e-3);
  }
}

/// A quadrotor hops sideways by 2 m per cycle and also repeats its pose; three solvers agree.
TEST(InitialChoice, AllConstrainedSolversSatisfyPoseCycles) {
  const std::string text = R"(conddp: 1
system: {type: quadrotor}
initial_state: {values: {z: 1}}
integrator: rk4
phases:
  - {name: start, choose: ["r*", "v*", "w*"], lower: -4, upper: 4}
  - {name: fly, knots: 20, dt: 0.05}
costs:
  thrust: {residual: control, reference: 1.22625}
  calm: {residual: state, reference: {values: {z: 1}}, weights: {"r*": 1, "w*": 0.1, "*": 0}}
constraints:
  side: {residual: state, columns: [y, z], knots: [11], equals: [0.3, 1.2]}
terminal:
  constraints:
    cycle: {residual: cycle, offset: {x: 2}}
initial_guess: {states: initial, controls: {constant: 1.22625}}
solver: {name: altro}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const ShootingProblem& problem = *loaded.built->problem;
  const StateManifold& manifold = loaded.built->plant.system->manifold();
  std::vector<double> costs;
  for (const char* solver : {"altro", "proxddp", "ipopt"}) {
    SolverOptions options;
    options.tolerances.constraint = 1e-8;
    const SolveResult result = solve(problem, solver, options, loaded.built->guess);
    ASSERT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    const Eigen::VectorXd first = result.trajectory.x(1), last = result.trajectory.x(21);
    Eigen::VectorXd target = first.head(manifold.nx()), off(manifold.ndx());
    target[0] += 2;
    manifold.difference(target.data(), last.data(), off.data());
    EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-7) << solver;
    EXPECT_GT(first.segment<3>(3).norm(), 0.01) << "the first pose is tilted";
    costs.push_back(result.cost);
  }
  EXPECT_NEAR(costs[1], costs[0], 1e-6);
  EXPECT_NEAR(costs[2], costs[0], 1e-6);
}

TEST(InitialChoice, NamedLinksLeaveTheOthersFree) {
  const Loaded loaded(choosing("{choose: all}", "cycle: {residual: cycle, equals: {omega: 0.5}}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const SolveResult result = solve(*loaded.built->problem, "altro", {}, loaded.built->guess);
  ASSERT_EQ(result.status, SolveStatus::converged) << result.message;
  EXPECT_NEAR(result.trajectory.x(11)[1], result.trajectory.x(1)[1] + 0.5, 1e-5);
  EXPECT_GT(std::abs(result.trajectory.x(11)[0] - result.trajectory.x(1)[0]), 1e-3);
}

TEST(InitialChoice, ContactImplicitStepsHaveCorrectDerivatives) {
  Diagnostics out;
  const auto spec = read_problem(kProblems / "raibert_gait.yaml", {}, out);
  ASSERT_TRUE(spec) << format_diagnostics(out, false);
  const auto built = build_problem(*spec, {}, out);
  ASSERT_TRUE(built) << format_diagnostics(out, false);
  for (const DerivativeComparison& c : check_derivatives(*built->problem, built->guess))
    EXPECT_LT(c.error, 1e-9) << "phase " << c.phase << ", row " << c.row << ", column " << c.column;
}

}  // namespace
}  // namespace conddp
