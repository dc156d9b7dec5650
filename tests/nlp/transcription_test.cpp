#include "nlp/transcription.hpp"

#include "support/constrained_problems.hpp"
#include "support/nlp_derivatives.hpp"
#include "systems/initial_choice.hpp"

namespace conddp {
namespace {

using testing::Added;
using testing::kFree;

/// A quadrotor with bounds on its whole state, a norm of its speed, and a cone of its rates.
ShootingProblem constrained_quadrotor() {
  const ShootingProblem free = testing::quadrotor_move(0, 20);
  const auto coordinates = [&](std::vector<int> list) {
    return coordinate_residual(free.manifold(), std::move(list));
  };
  std::vector<double> low(12, -5), up(12, kFree);
  low[1] = -kFree;
  up[2] = 3;
  return testing::with_constraints(free, {{.name = "room",
                                           .residual = state_residual(free.manifold()),
                                           .reference = free.initial_state(),
                                           .lower = low,
                                           .upper = up,
                                           .first = 1,
                                           .last = 50},
                                          {.name = "speed",
                                           .residual = coordinates({7, 8, 9}),
                                           .kind = ConstraintKind::norm,
                                           .reference = {0, 0, 0},
                                           .lower = {-kFree},
                                           .upper = {4},
                                           .first = 5,
                                           .last = 40},
                                          {.name = "cone",
                                           .residual = coordinates({10, 11, 12}),
                                           .kind = ConstraintKind::second_order_cone,
                                           .reference = {0.1, 0.2, -3},
                                           .first = 2,
                                           .last = 50,
                                           .slope = 0.8}});
}

ShootingProblem euler_cartpole() {
  return testing::cartpole_swing_up(20, Integrator::semi_implicit_euler);
}

/// A trajectory with rotations that differ from the initial state.
Trajectory random_trajectory(const ShootingProblem& problem, double size, std::mt19937_64& engine) {
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k <= t.knots(); ++k) {
    const Eigen::VectorXd dx = size * testing::random_vector(problem.ndx(), engine);
    Eigen::VectorXd moved = t.x(k);
    problem.manifold().integrate(moved.data(), dx.data(), moved.data());
    if (k > 0) t.x(k) = moved;
    if (k < t.knots()) t.u(k) = 3 * size * testing::random_vector(problem.nu(k), engine);
  }
  return t;
}

TEST(Transcription, DerivativesMatchDifferencesFarFromChartCenters) {
  std::mt19937_64 engine(5);
  std::vector<ShootingProblem> problems;
  problems.push_back(testing::pendulum_swing_up(3));
  problems.push_back(constrained_quadrotor());
  problems.push_back(testing::landing());
  problems.push_back(euler_cartpole());
  for (auto& published : testing::published_cases())
    problems.push_back(std::move(published.problem));
  for (const ShootingProblem& problem : problems) {
    Evaluator evaluator(problem);
    Transcription program(problem, evaluator, {});
    for (const double size : {0.1, 0.6}) {
      SCOPED_TRACE(size);
      program.set_center(random_trajectory(problem, size, engine));
      const Eigen::VectorXd y = program.point_of(random_trajectory(problem, size, engine));
      testing::check_derivatives(program, y, engine, 1e-6);
    }
  }
}

TEST(Transcription, PointsRepresentTrajectories) {
  std::mt19937_64 engine(6);
  const ShootingProblem problem = constrained_quadrotor();
  Evaluator evaluator(problem);
  Transcription program(problem, evaluator, {});
  program.set_center(random_trajectory(problem, 0.5, engine));
  const Trajectory trajectory = random_trajectory(problem, 0.5, engine);
  const Eigen::VectorXd y = program.point_of(trajectory);
  program.set_point(y.data());
  Eigen::VectorXd off(problem.ndx());
  for (int k = 0; k <= problem.knots(); ++k) {
    problem.manifold().difference(trajectory.x(k).data(), program.trajectory().x(k).data(),
                                  off.data());
    EXPECT_LE(off.lpNorm<Eigen::Infinity>(), 1e-12) << k;
  }
  EXPECT_GT(program.chart_angle(), 0.1);
  program.set_center(trajectory);
  const Eigen::VectorXd centred = program.point_of(trajectory);
  program.set_point(centred.data());
  EXPECT_LE(program.chart_angle(), 1e-12);
}

/// With closed gaps, the gradient of the program's Lagrangian with respect to u is s ℓ_u + f_uᵀ λ +
/// Cᵀ ν for any charts and cones.
void expect_multipliers_of_solvers(const ShootingProblem& problem, double control) {
  std::mt19937_64 engine(7);
  Evaluator evaluator(problem);
  Transcription program(problem, evaluator, {});
  Trajectory trajectory = problem.create_trajectory();
  for (int k = 0; k < trajectory.knots(); ++k)
    trajectory.u(k).array() = control + 0.1 * testing::random_vector(problem.nu(k), engine).array();
  ASSERT_EQ(evaluator.simulate(trajectory), -1);
  program.set_center(random_trajectory(problem, 0.3, engine));
  const Eigen::VectorXd y = program.point_of(trajectory);
  program.set_point(y.data());
  Eigen::VectorXd rows = testing::random_vector(program.rows(), engine);
  const Eigen::VectorXd gradient = testing::lagrangian_gradient(program, 1, rows);
  Eigen::MatrixXd costates;
  Eigen::VectorXd nu;
  program.read_multipliers(rows.data(), costates, nu);
  Linearization linearization(problem);
  evaluator.differentiate(trajectory, linearization);
  int at = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    const KnotLinearization& knot = linearization.knots[k];
    const Eigen::VectorXd expected =
        knot.gradient + knot.dense_jacobian().transpose() * costates.col(k + 1) +
        knot.C.transpose() * nu.segment(problem.constraint_offset(k), knot.C.rows());
    if (k > 0) at += problem.ndx();
    const int controls = problem.nu(k);
    EXPECT_LE((gradient.segment(at, controls) - expected.tail(controls)).lpNorm<Eigen::Infinity>(),
              1e-9)
        << k;
    at += controls;
  }
  // The same costates in charts centered on the trajectory.
  program.recenter_multipliers(rows.data());
  program.set_center(trajectory);
  const Eigen::VectorXd centred = program.point_of(trajectory);
  program.set_point(centred.data());
  Eigen::MatrixXd again;
  program.read_multipliers(rows.data(), again, nu);
  EXPECT_LE((again - costates).lpNorm<Eigen::Infinity>(), 1e-9);
}

TEST(Transcription, MultipliersMatchTheSolvers) {
  expect_multipliers_of_solvers(constrained_quadrotor(), 2.5);
  expect_multipliers_of_solvers(euler_cartpole(), 0);
}

TEST(Transcription, FindsRowMultipliersFromCostates) {
  std::mt19937_64 engine(9);
  const ShootingProblem problem = euler_cartpole();
  Evaluator evaluator(problem);
  Transcription program(problem, evaluator, {});
  const Trajectory trajectory = random_trajectory(problem, 0.3, engine);
  program.set_center(trajectory);
  const Eigen::VectorXd y = program.point_of(trajectory);
  program.set_point(y.data());
  const Eigen::VectorXd rows = testing::random_vector(program.rows(), engine);
  Eigen::MatrixXd costates;
  Eigen::VectorXd nu, again, lower, upper;
  program.read_multipliers(rows.data(), costates, nu);
  const std::vector<Eigen::VectorXd> gradient(problem.knots(), Eigen::VectorXd::Zero(1));
  program.write_multipliers(costates, nu, gradient, again, lower, upper);
  EXPECT_LE((again - rows).lpNorm<Eigen::Infinity>(), 1e-14);
}

/// q + dt v⁺ − q⁺, except for the given q of the first knot.
TEST(Transcription, FlatConfigurationsHaveRowsOfThreeEntries) {
  std::mt19937_64 engine(10);
  const ShootingProblem problem = euler_cartpole();
  Evaluator evaluator(problem);
  Transcription program(problem, evaluator, {});
  const Eigen::VectorXd y = testing::random_vector(program.variables(), engine);
  program.set_point(y.data());
  Eigen::VectorXd values(program.jacobian_structure().size()), rows(program.rows());
  program.jacobian(values.data());
  program.constraints(rows.data());
  std::vector<std::vector<double>> entries(program.rows());
  for (int i = 0; i < values.size(); ++i)
    entries[program.jacobian_structure().rows[i]].push_back(values[i]);
  for (int k = 1; k < problem.knots(); ++k)
    for (int i = 0; i < 2; ++i) {
      const double dt = problem.knot(k).dt;
      EXPECT_EQ(entries[4 * k + i], (std::vector<double>{1, -1, dt}));
      const auto x = program.trajectory().x(k), next = program.trajectory().x(k + 1);
      EXPECT_NEAR(rows[4 * k + i], x[i] + dt * next[2 + i] - next[i], 1e-12);
    }
}

TEST(Transcription, GaussNewtonHessiansMatchTheEvaluation) {
  const ShootingProblem problem = testing::pendulum_swing_up(3);
  Evaluator evaluator(problem);
  Transcription program(problem, evaluator, {.gauss_newton = true});
  std::mt19937_64 engine(8);
  const Trajectory trajectory = random_trajectory(problem, 0.5, engine);
  const Eigen::VectorXd y = program.point_of(trajectory);
  program.set_point(y.data());
  Linearization linearization(problem);
  evaluator.differentiate(trajectory, linearization);
  const Eigen::VectorXd multipliers = testing::random_vector(program.rows(), engine);
  const Eigen::VectorXd d = testing::random_vector(program.variables(), engine);
  const Eigen::VectorXd product = testing::hessian_times(program, 2, multipliers, d);
  EXPECT_NEAR(product[0], 2 * linearization.knots[0].hessian()(2, 2) * d[0], 1e-12);
  EXPECT_LE((product.segment(1, 3) - 2 * linearization.knots[1].hessian() * d.segment(1, 3)).norm(),
            1e-12);
}

TEST(Transcription, DetectsRowsLinkingStatesToControls) {
  const auto is_mixed = [](const ShootingProblem& problem) {
    Evaluator evaluator(problem);
    return Transcription(problem, evaluator, {}).has_mixed_rows();
  };
  EXPECT_FALSE(is_mixed(constrained_quadrotor()));
  EXPECT_FALSE(is_mixed(testing::landing()));  // a cone of thrust and another of positions
  const ShootingProblem free = euler_cartpole();
  for (const bool mixed : {false, true}) {
    std::vector<LinearCombination> rows(1);
    rows[0].terms = {{.factor = 1, .of_control = true, .index = 0, .tangent = 0}};
    if (mixed)
      rows[0].terms.push_back({.factor = 0.5, .of_control = false, .index = 2, .tangent = 2});
    EXPECT_EQ(is_mixed(testing::with_constraints(
                  free, {{.name = "sum",
                          .residual = combination_residual(free.ndx(), std::move(rows)),
                          .reference = {},
                          .lower = {-kFree},
                          .upper = {10},
                          .first = 1,
                          .last = 5}})),
              mixed);
  }
}

/// The order of requests, here or at another point, does not matter.
TEST(Transcription, HessiansMayChangeKindBetweenCalls) {
  std::mt19937_64 engine(9);
  for (const ShootingProblem& problem :
       {constrained_quadrotor(), testing::landing(), euler_cartpole()}) {
    Evaluator evaluator(problem);
    Transcription exact(problem, evaluator, {}), alternating(problem, evaluator, {});
    Transcription gauss_newton(problem, evaluator, {.gauss_newton = true});
    const Trajectory center = random_trajectory(problem, 0.1, engine);
    for (Transcription* program : {&exact, &alternating, &gauss_newton})
      program->set_center(center);
    const Eigen::VectorXd multipliers = testing::random_vector(exact.rows(), engine);
    const Eigen::VectorXd d = testing::random_vector(exact.variables(), engine);
    Eigen::VectorXd y;
    double apart = 0;
    for (const auto& [moves, is_exact] : {std::pair{true, true},
                                          {false, false},
                                          {false, true},
                                          {true, false},
                                          {true, true},
                                          {true, false}}) {
      if (moves) y = exact.point_of(random_trajectory(problem, 0.3, engine));
      for (Transcription* program : {&exact, &alternating, &gauss_newton})
        program->set_point(y.data());
      alternating.use_gauss_newton(!is_exact);
      const Eigen::VectorXd wanted =
          testing::hessian_times(is_exact ? exact : gauss_newton, 2, multipliers, d);
      const Eigen::VectorXd got = testing::hessian_times(alternating, 2, multipliers, d);
      EXPECT_LE((got - wanted).norm(), 1e-12 * wanted.norm());
      apart = std::max(
          apart, (got - testing::hessian_times(is_exact ? gauss_newton : exact, 2, multipliers, d))
                     .norm());
    }
    EXPECT_GT(apart, 1e-3);
  }
}

TEST(Transcription, ConstraintsOnTheGivenStateAddNoRows) {
  const ShootingProblem free = testing::cartpole_swing_up(3);
  const auto with_first = [&](int first) {
    return testing::with_constraints(free, {{.name = "track",
                                             .residual = coordinate_residual(free.manifold(), {0}),
                                             .reference = {0},
                                             .lower = {-1},
                                             .upper = {1},
                                             .first = first,
                                             .last = 100}});
  };
  const ShootingProblem all = with_first(0), later = with_first(1);
  Evaluator acts_of_all(all), acts_of_later(later);
  EXPECT_EQ(Transcription(all, acts_of_all, {}).rows(),
            Transcription(later, acts_of_later, {}).rows());
}

/// The cart-pole with a free initial angle and a bound on the cart's position (0) or the angle (1)
/// from node `first`.
ShootingProblem chosen_angle(int coordinate, int first) {
  const ShootingProblem given = testing::cartpole_swing_up(3);
  const System& system = given.knot(0).model->system();
  std::vector<Phase> phases{
      {.name = "start",
       .model = std::make_shared<KnotModel>(initial_choice(system, {1}, {{"angle", "rad"}}),
                                            Integrator::explicit_euler),
       .dt = {1.0},
       .cost_scale = {1.0},
       .parameters = {},
       .instant = true}};
  phases.insert(phases.end(), given.phases().begin(), given.phases().end());
  const ShootingProblem free(given.initial_state(), std::move(phases), given.terminal());
  return testing::with_constraints(free,
                                   {{.name = "track",
                                     .residual = coordinate_residual(free.manifold(), {coordinate}),
                                     .reference = {0},
                                     .lower = {0},
                                     .upper = {1},
                                     .first = first,
                                     .last = 100}});
}

TEST(Transcription, ConstraintsOnUnchosenInitialStatesAddNoRows) {
  const auto rows = [](int coordinate, int first) {
    const ShootingProblem problem = chosen_angle(coordinate, first);
    Evaluator evaluator(problem);
    return Transcription(problem, evaluator, {}).rows();
  };
  EXPECT_EQ(rows(0, 1), rows(0, 2)) << "the cart's place is given";
  EXPECT_EQ(rows(1, 1), rows(1, 2) + 1) << "the angle is chosen";
}

TEST(Transcription, KnowsNodesOfUnchangeableConstraints) {
  const auto given = [](const ShootingProblem& problem) {
    Evaluator evaluator(problem);
    const Transcription program(problem, evaluator, {});
    EXPECT_TRUE(program.has_given_constraints(0));
    EXPECT_FALSE(program.has_given_constraints(2));
    return program.has_given_constraints(1);
  };
  EXPECT_FALSE(given(testing::cartpole_swing_up(3)));
  EXPECT_TRUE(given(chosen_angle(0, 1)));
  EXPECT_FALSE(given(chosen_angle(0, 2)));
  EXPECT_FALSE(given(chosen_angle(1, 1)));
}

}  // namespace
}  // namespace conddp
