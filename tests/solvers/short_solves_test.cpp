// Counts of solves so short that rounding decides nothing: every change of a decision changes one
// of the counts.
#include <functional>

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "solvers/strategies/registry.hpp"
#include "support/conic_problems.hpp"
#include "support/linear_quadratic.hpp"
#include "support/pair_wishes.hpp"
#include "support/plain_pendulum.hpp"

namespace conddp::testing {
namespace {

/// "converged: 12 iterations, 14 sweeps, 20 trials, ..." over the whole log, without zero counts.
std::string way_of(const SolveResult& result) {
  int sweeps = 0, trials = 0, full = 0, exact = 0, regularized = 0, changes = 0, clamped = 0;
  for (std::size_t i = 1; i < result.log.size(); ++i) {
    const IterationRecord& row = result.log[i];
    sweeps += row.sweeps;
    trials += row.trials;
    full += row.step == 1;
    exact += row.exact_hessian;
    regularized += row.regularization > 0;
    changes += row.active_set_changes;
    clamped += row.clamped_controls;
  }
  const IterationRecord& last = result.log.back();
  const int more_rows = static_cast<int>(result.log.size()) - 1 - result.iterations;
  std::string text = fmt::format("{}: {} iterations", to_string(result.status), result.iterations);
  for (const auto& [count, what] : {std::pair{more_rows, "more rows"},
                                    {sweeps, "sweeps"},
                                    {trials, "trials"},
                                    {full, "full"},
                                    {exact, "exact"},
                                    {regularized, "regularized"},
                                    {changes, "changes"},
                                    {clamped, "clamped"},
                                    {last.outer, "outer"},
                                    {last.newton, "newton"},
                                    {last.active_rows, "active"},
                                    {last.fallbacks, "fallbacks"}})
    if (count != 0) text += fmt::format(", {} {}", count, what);
  return text;
}

struct ShortSolve {
  std::string name;
  std::function<ShootingProblem()> problem;
  std::string solver;
  std::string way;
  double control = 0.1;  ///< of the guess
  SolverOptions options = {};
};

void PrintTo(const ShortSolve& solve, std::ostream* out) {
  *out << solve.solver << ' ' << solve.name;
}

ShootingProblem bounded_quadratic() {
  return std::move(*LinearQuadratic(3, 4, {2, 3}, 5, -0.3, 0.3, 1.05).problem);
}
ShootingProblem swinging(double limit) {
  PlainPendulum pendulum;
  pendulum.knots = 12;
  pendulum.limit = limit;
  return pendulum.problem();
}
ShootingProblem riding(double limit) {
  return tracking_problem(unicycle(), Integrator::rk4, 12, 0.1, {0, 0, 0.3},
                          {{1, 1, 0}, {1, 1, 1}, {0.5, 0.5}, {10, 10, 10}}, -limit, limit);
}
ShootingProblem pole(int knots) {
  return tracking_problem(cartpole({}), Integrator::rk4, knots, 0.05, {0, 2.5, 0, 0},
                          {{0, M_PI, 0, 0}, {1, 1, 0.1, 0.1}, {0.1}, {10, 100, 10, 10}}, -9, 9);
}
/// A mass that must rest at its goal, with a speed limit until then.
ShootingProblem mass_to(double goal, double limit) {
  const auto free = tracking_problem(double_integrator(1), Integrator::rk4, 10, 0.2, {0, 0},
                                     {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  return with_constraints(free, {{.name = "speed",
                                  .residual = coordinate_residual(free.manifold(), {1}),
                                  .reference = {0},
                                  .lower = {-limit},
                                  .upper = {limit},
                                  .first = 1,
                                  .last = 10},
                                 goal_constraint(free, {goal, 0})});
}
/// A mass with a soft speed limit.
ShootingProblem soft_mass() {
  const auto free = tracking_problem(double_integrator(1), Integrator::rk4, 10, 0.2, {0, 0},
                                     {{1, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  return with_constraints(free, {{.name = "speed",
                                  .residual = coordinate_residual(free.manifold(), {1}),
                                  .reference = {0},
                                  .lower = {-0.4},
                                  .upper = {0.4},
                                  .first = 1,
                                  .last = 10,
                                  .softness = Softness::l1,
                                  .weight = 0.3}});
}
ShootingProblem pendulum_goal(double limit) {
  const ShootingProblem free = swinging(limit);
  return with_constraints(free, {goal_constraint(free, {1, 0})});
}
ShootingProblem cones(double control) {
  return std::move(*ConicLinearQuadratic(2, {.nx = 4,
                                             .nu = 3,
                                             .knots = 5,
                                             .equalities = 1,
                                             .boxes = 2,
                                             .cones = 1,
                                             .cone_rows = 3,
                                             .terminal = 1,
                                             .control = control})
                        .problem);
}
ShootingProblem disc() {
  const ShootingProblem free = riding(3);
  return with_constraints(free, {{.name = "disc",
                                  .residual = coordinate_residual(free.manifold(), {0, 1}),
                                  .kind = ConstraintKind::norm,
                                  .reference = {0.5, 0.4},
                                  .lower = {0.25},
                                  .upper = {kFree},
                                  .first = 1,
                                  .last = 11}});
}

SolverOptions with_hessian(HessianChoice hessian) { return {.hessian = hessian}; }
SolverOptions with_relaxation(PairRelaxation way) {
  SolverOptions options;
  options.complementarity.relaxation = way;
  return options;
}
SolverOptions with_tolerance(double tolerance) {
  SolverOptions options;
  options.tolerances.stationarity = options.tolerances.complementarity =
      options.tolerances.constraint = tolerance;
  return options;
}

std::vector<ShortSolve> short_solves() {
  const auto bounded = [] { return swinging(2); };
  const auto free = [] { return swinging(kFree); };
  const auto ride = [] { return riding(2); };
  const auto far = [] { return mass_to(6, 0.6); };
  const auto near = [] { return mass_to(0.6, 0.45); };
  const auto balance = [] { return pole(12); };
  const auto goal = [] { return pendulum_goal(4); };
  const std::vector<Eigen::Vector2d> wishes = {{1, 3}, {2, 0.5}, {-1, 1}, {4, -2}};
  const auto pairs = [=] { return wishes_for_pairs(wishes); };
  return {
      {"quadratic", bounded_quadratic, "box_ddp",
       "converged: 1 iterations, 4 sweeps, 1 trials, 1 full, 13 clamped"},
      {"quadratic", bounded_quadratic, "box_fddp",
       "converged: 1 iterations, 4 sweeps, 1 trials, 1 full, 13 clamped"},
      {"quadratic", bounded_quadratic, "ilqr_clip",
       "line_search_failed: 1 iterations, 1 sweeps, 1 trials, 1 full"},
      {"quadratic", bounded_quadratic, "ipopt",
       "converged: 11 iterations, 1 sweeps, 10 trials, 8 full, 11 exact, 1 newton, 13 active"},
      {"swing", free, "ilqr", "converged: 7 iterations, 7 sweeps, 7 trials, 7 full"},
      {"swing", free, "ddp", "converged: 4 iterations, 4 sweeps, 4 trials, 4 full, 4 exact"},
      {"swing", free, "fddp", "converged: 6 iterations, 6 sweeps, 6 trials, 6 full"},
      {"swing", bounded, "box_ddp",
       "converged: 6 iterations, 8 sweeps, 6 trials, 6 full, 36 clamped"},
      {"swing", bounded, "box_fddp",
       "converged: 5 iterations, 6 sweeps, 5 trials, 5 full, 30 clamped"},
      {"swing", bounded, "ipopt",
       "converged: 11 iterations, 1 sweeps, 10 trials, 11 full, 11 exact, 1 newton, 6 active"},
      {"swing_exact", bounded, "box_fddp",
       "converged: 3 iterations, 4 sweeps, 3 trials, 3 full, 2 exact, 18 clamped", 0.1,
       with_hessian(HessianChoice::exact)},
      {"swing_plain", bounded, "box_fddp",
       "converged: 5 iterations, 6 sweeps, 5 trials, 5 full, 30 clamped", 0.1,
       with_hessian(HessianChoice::gauss_newton)},
      {"swing_plain", bounded, "ipopt",
       "converged: 17 iterations, 1 sweeps, 16 trials, 17 full, 1 newton, 6 active", 0.1,
       with_hessian(HessianChoice::gauss_newton)},
      {"ride", ride, "box_ddp",
       "converged: 12 iterations, 16 sweeps, 12 trials, 12 full, 2 clamped"},
      {"ride", ride, "box_fddp",
       "converged: 11 iterations, 13 sweeps, 11 trials, 11 full, 1 clamped"},
      {"ride", ride, "ilqr_clip", "converged: 21 iterations, 21 sweeps, 22 trials, 20 full"},
      {"ride", ride, "ipopt", "converged: 12 iterations, 12 trials, 12 full, 12 exact"},
      {"balance", balance, "box_ddp",
       "converged: 5 iterations, 10 sweeps, 5 trials, 5 full, 56 clamped"},
      {"mass", near, "altro",
       "converged: 7 iterations, 11 sweeps, 6 trials, 7 full, 5 outer, 1 newton, 5 active"},
      {"mass", near, "proxddp", "converged: 8 iterations, 10 sweeps, 8 trials, 8 full, 7 outer"},
      {"mass", near, "ipopt",
       "converged: 12 iterations, 2 sweeps, 11 trials, 12 full, 12 exact, 1 newton, 5 active"},
      {"mass_tight", near, "altro",
       "converged: 7 iterations, 11 sweeps, 6 trials, 7 full, 5 outer, 1 newton, 5 active", 0.1,
       with_tolerance(1e-10)},
      {"mass_tight", near, "proxddp",
       "converged: 10 iterations, 12 sweeps, 10 trials, 10 full, 9 outer", 0.1,
       with_tolerance(1e-9)},
      {"mass_tight", near, "ipopt",
       "converged: 13 iterations, 2 sweeps, 12 trials, 13 full, 13 exact, 1 newton, 5 active", 0.1,
       with_tolerance(1e-11)},
      {"mass_far", far, "altro",
       "infeasible: 9 iterations, 1 more rows, 15 sweeps, 9 trials, 9 full, 19 clamped, 1 outer"},
      {"mass_far", far, "proxddp",
       "infeasible: 9 iterations, 1 more rows, 16 sweeps, 9 trials, 9 full, 18 clamped, 1 outer"},
      {"mass_soft", soft_mass, "altro",
       "converged: 8 iterations, 11 sweeps, 8 trials, 8 full, 7 outer"},
      {"mass_soft", soft_mass, "proxddp",
       "converged: 7 iterations, 10 sweeps, 7 trials, 7 full, 6 outer"},
      {"mass_soft", soft_mass, "ipopt",
       "converged: 11 iterations, 2 sweeps, 10 trials, 7 full, 11 exact, 1 newton, 2 active"},
      {"goal", [] { return pendulum_goal(kFree); }, "intro",
       "converged: 5 iterations, 5 sweeps, 5 trials, 5 full"},
      {"goal", goal, "proxddp", "converged: 16 iterations, 16 sweeps, 16 trials, 16 full, 8 outer"},
      {"goal", goal, "ipopt",
       "converged: 8 iterations, 4 sweeps, 7 trials, 8 full, 8 exact, 1 newton, 2 active"},
      {"disc", disc, "altro",
       "converged: 29 iterations, 38 sweeps, 28 trials, 27 full, 8 exact, 18 clamped, 6 outer, 3 "
       "newton, 3 active"},
      {"disc", disc, "proxddp",
       "converged: 32 iterations, 41 sweeps, 35 trials, 29 full, 10 exact, 24 clamped, 8 outer"},
      {"disc", disc, "ipopt",
       "converged: 37 iterations, 2 sweeps, 40 trials, 21 full, 37 exact, 18 regularized, 1 "
       "newton, 4 active"},
      {"cones", [] { return cones(1); }, "proxddp",
       "converged: 17 iterations, 24 sweeps, 17 trials, 17 full, 8 outer"},
      {"cones", [] { return cones(1); }, "ipopt",
       "converged: 14 iterations, 3 sweeps, 14 trials, 11 full, 14 exact, 1 regularized, 1 newton, "
       "10 active"},
      {"pairs", pairs, "ipopt",
       "converged: 35 iterations, 35 trials, 28 full, 35 exact, 3 regularized, 8 outer", 0,
       with_relaxation(PairRelaxation::elementwise)},
      {"pairs_fischer", pairs, "ipopt",
       "converged: 28 iterations, 28 trials, 23 full, 28 exact, 8 outer", 0,
       with_relaxation(PairRelaxation::fischer_burmeister)},
      {"pairs_penalty", pairs, "ipopt",
       "converged: 18 iterations, 18 trials, 10 full, 18 exact, 4 outer", 0,
       with_relaxation(PairRelaxation::penalty)},
      {"pairs_product", pairs, "ipopt",
       "converged: 35 iterations, 35 trials, 28 full, 35 exact, 3 regularized, 8 outer", 0,
       with_relaxation(PairRelaxation::inner_product)},
  };
}

class WayOfAShortSolve : public ::testing::TestWithParam<ShortSolve> {};

TEST_P(WayOfAShortSolve, MatchesItsMeasurement) {
  const ShortSolve& solve_of = GetParam();
  const ShootingProblem problem = solve_of.problem();
  const SolveResult result = solve(problem, solve_of.solver, solve_of.options,
                                   constant_controls(problem, solve_of.control));
  EXPECT_EQ(way_of(result), solve_of.way);
}

INSTANTIATE_TEST_SUITE_P(All, WayOfAShortSolve, ::testing::ValuesIn(short_solves()),
                         [](const auto& suite) {
                           return suite.param.solver + "_" + suite.param.name;
                         });

}  // namespace
}  // namespace conddp::testing
