// Margins of bounds under noise, compared with formulas and with random runs of the linear closed
// loop.
#include "analysis/margins/margins.hpp"

#include <cmath>
#include <set>
#include <stdexcept>

#include <gtest/gtest.h>

#include "base/random_numbers.hpp"
#include "ocp/residuals/residuals.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "systems/closed_forms/catalogue.hpp"

namespace conddp {
namespace {

/// x⁺ = 0.9 x + 0.5 u, three knots, −2 ≤ u ≤ 1.
ShootingProblem scalar_problem() {
  const auto one = [](double value) { return Eigen::MatrixXd::Constant(1, 1, value); };
  return testing::tracking_problem(linear_system(one(0.9), one(0.5), Eigen::VectorXd::Zero(1)),
                                   Integrator::discrete, 3, 0.1, {1}, {{0}, {1}, {1}, {1}}, -2, 1);
}

std::vector<Eigen::MatrixXd> scalar_gains() { return {3, Eigen::MatrixXd::Constant(1, 1, -0.8)}; }

StateNoise noise(double initial, double process, double measurement, int n) {
  return {Eigen::VectorXd::Constant(n, initial), Eigen::VectorXd::Constant(n, process),
          Eigen::VectorXd::Constant(n, measurement)};
}

// (0.9 − 0.5·0.8)² P + (0.5·0.8)² N + W, starting at P = 0.04.
TEST(Margins, CovarianceFollowsItsRecursion) {
  const ShootingProblem problem = scalar_problem();
  Linearization linear(problem);
  Evaluator(problem).differentiate(problem.create_trajectory(), linear);
  const auto P = propagate_covariance(problem, linear, scalar_gains(), noise(0.2, 0.1, 0.3, 1));
  ASSERT_EQ(P.size(), 4u);
  double expected = 0.04;
  for (const Eigen::MatrixXd& covariance : P) {
    EXPECT_NEAR(covariance(0, 0), expected, 1e-15);
    expected = 0.25 * expected + 0.16 * 0.09 + 0.01;
  }
}

// u = −0.8 (δx + n) has the standard deviation 0.8 √(0.04 + 0.09) at the first knot.
TEST(Margins, ControlVarianceIncludesStateAndMeasurementNoise) {
  const ShootingProblem problem = scalar_problem();
  Trajectory trajectory = problem.create_trajectory();
  trajectory.u(0)[0] = 0.25;
  const auto curves =
      constraint_margins(problem, trajectory, scalar_gains(), noise(0.2, 0, 0.3, 1));
  ASSERT_EQ(curves.size(), 2u);
  EXPECT_TRUE(curves[0].upper);
  const Margin& first = curves[0].nodes.front();
  EXPECT_EQ(first.knot, 0);
  EXPECT_NEAR(first.distance, 0.75, 1e-15);
  EXPECT_NEAR(first.sigma, 0.8 * std::sqrt(0.13), 1e-15);
  EXPECT_NEAR(first.steps(), 0.75 / (0.8 * std::sqrt(0.13)), 1e-14);
  EXPECT_EQ(&curves[0].smallest(), &first);
  EXPECT_NEAR(curves[1].nodes.front().distance, 2.25, 1e-15);
}

TEST(Margins, ProbabilitiesFollowTheNormalLaw) {
  // Abramowitz and Stegun, table 26.1.
  const auto of = [](double steps) { return Margin{.distance = steps, .sigma = 1}.probability(); };
  EXPECT_NEAR(of(0), 0.5, 1e-15);
  EXPECT_NEAR(of(1), 0.158655253931457, 1e-15);
  EXPECT_NEAR(of(-1), 0.841344746068543, 1e-15);
  EXPECT_NEAR(of(3), 0.001349898031630, 1e-15);
}

// Solvers leave tiny gains on controls at their bounds.
TEST(Margins, SkipQuantitiesHeldAtTheirBound) {
  const ShootingProblem problem = scalar_problem();
  std::vector<Eigen::MatrixXd> gains = scalar_gains();
  gains[0](0, 0) = -1e-9;
  const auto first_knot_of_upper = [&](double u) {
    Trajectory trajectory = problem.create_trajectory();
    trajectory.u(0)[0] = u;
    for (const MarginCurve& curve :
         constraint_margins(problem, trajectory, gains, noise(0.2, 0.1, 0, 1)))
      if (curve.upper) return curve.nodes.front().knot;
    return -1;
  };
  EXPECT_EQ(first_knot_of_upper(1), 1);
  EXPECT_EQ(first_knot_of_upper(1 - 1e-3), 0);
}

// A ten-thousandth of the usual deviation, a millionth from the bound.
TEST(Margins, SmallGainsNearABoundCountAsHeld) {
  const ShootingProblem problem = scalar_problem();
  for (const bool upper : {true, false}) {
    const auto is_held = [&](double share, double distance) {
      std::vector<Eigen::MatrixXd> gains = scalar_gains();
      gains[0](0, 0) = -0.8 * share;
      Trajectory trajectory = problem.create_trajectory();
      trajectory.u(0)[0] = upper ? 1 - distance : -2 + distance;
      for (const MarginCurve& curve :
           constraint_margins(problem, trajectory, gains, noise(0.2, 0, 0, 1)))
        if (curve.upper == upper) return curve.nodes.front().knot != 0;
      return false;
    };
    // The second knot's deviation is 0.9 times the first knot's.
    EXPECT_TRUE(is_held(0.8e-4, 0.9e-6)) << upper;
    EXPECT_TRUE(is_held(0.8e-4, -0.9e-6)) << upper;
    EXPECT_FALSE(is_held(0.8e-4, 1.1e-6)) << upper;
    EXPECT_FALSE(is_held(0.8e-4, -1.1e-6)) << upper;
    EXPECT_FALSE(is_held(1.1e-4, 0.9e-6)) << upper;
  }
}

/// The scalar problem with its first knots instantaneous.
ShootingProblem with_instants(const std::set<int>& instants) {
  const ShootingProblem whole = scalar_problem();
  std::vector<Phase> phases;
  for (int k = 0; k < whole.knots(); ++k) {
    Phase phase = whole.phases()[0];
    phase.dt.resize(1);
    phase.cost_scale.resize(1);
    phase.parameters.resize(phase.model->parameter_count());
    phase.instant = instants.contains(k);
    phases.push_back(std::move(phase));
  }
  return {whole.initial_state(), std::move(phases), whole.terminal()};
}

// Noise starts with time; instantaneous knots add no disturbance or measurement error.
TEST(Margins, BeginWithTimeAndPassInstantsWithoutNoise) {
  const StateNoise all = noise(0.2, 0.1, 0.3, 1);
  const auto covariances = [&](const std::set<int>& instants) {
    const ShootingProblem problem = with_instants(instants);
    Linearization linear(problem);
    Evaluator(problem).differentiate(problem.create_trajectory(), linear);
    std::vector<double> list;
    for (const Eigen::MatrixXd& P : propagate_covariance(problem, linear, scalar_gains(), all))
      list.push_back(P(0, 0));
    return list;
  };
  constexpr double kAdded = 0.16 * 0.09 + 0.01;
  const auto expect_near = [](const std::vector<double>& found,
                              const std::vector<double>& expected) {
    ASSERT_EQ(found.size(), expected.size());
    for (std::size_t k = 0; k < found.size(); ++k) EXPECT_NEAR(found[k], expected[k], 1e-15) << k;
  };
  const double second = 0.25 * 0.04 + kAdded;
  expect_near(covariances({0}), {0, 0.04, second, 0.25 * second + kAdded});
  expect_near(covariances({0, 1}), {0, 0, 0.04, second});
  expect_near(covariances({1}), {0.04, second, 0.25 * second, 0.25 * 0.25 * second + kAdded});
  const auto knots = [&](const std::set<int>& instants) {
    const ShootingProblem problem = with_instants(instants);
    const auto curves =
        constraint_margins(problem, problem.create_trajectory(), scalar_gains(), all);
    std::vector<int> list;
    for (const Margin& margin : curves.at(0).nodes) list.push_back(margin.knot);
    return list;
  };
  EXPECT_EQ(knots({}), (std::vector{0, 1, 2}));
  EXPECT_EQ(knots({0}), (std::vector{1, 2}));
  EXPECT_EQ(knots({1}), (std::vector{0, 2}));
}

// A row at an instant before time starts has no margin; a later one uses the state alone.
TEST(Margins, RowsAtInstantsUseTheStateAlone) {
  for (const int instant : {0, 1}) {
    const ShootingProblem free = with_instants({instant});
    using Term = LinearCombination::Term;
    const ShootingProblem problem = testing::with_constraints(
        free, {{.name = "push",
                .residual = combination_residual(1, {{.terms = {Term{1, true, 0, 0}}}}),
                .lower = {-4},
                .upper = {5},
                .first = 0,
                .last = 2}});
    const auto curves = constraint_margins(problem, problem.create_trajectory(), scalar_gains(),
                                           noise(0.2, 0, 0.3, 1));
    std::vector<std::pair<int, double>> margins;
    for (const MarginCurve& curve : curves)
      if (curve.name == "push" && curve.upper)
        for (const Margin& margin : curve.nodes) margins.emplace_back(margin.knot, margin.sigma);
    ASSERT_EQ(margins.size(), instant == 0 ? 2u : 3u);
    EXPECT_EQ(margins.front().first, instant == 0 ? 1 : 0);
    EXPECT_NEAR(margins.front().second, 0.8 * std::sqrt(0.04 + 0.09), 1e-15);
    if (instant == 0) continue;
    EXPECT_NEAR(margins[1].second, 0.8 * std::sqrt(0.25 * 0.04 + 0.16 * 0.09), 1e-15);
  }
}

TEST(Margins, NoiseWithNonFiniteSquareIsAnError) {
  const ShootingProblem problem = scalar_problem();
  const Trajectory trajectory = problem.create_trajectory();
  for (const StateNoise& large :
       {noise(1e155, 0, 0, 1), noise(0, 1e155, 0, 1), noise(0, 0, 1e155, 1)})
    EXPECT_THROW(constraint_margins(problem, trajectory, scalar_gains(), large),
                 std::overflow_error);
}

TEST(Margins, ControlsWithoutGainsHaveNoMargin) {
  const ShootingProblem problem = scalar_problem();
  const std::vector<Eigen::MatrixXd> held(3, Eigen::MatrixXd::Zero(1, 1));
  EXPECT_TRUE(
      constraint_margins(problem, problem.create_trajectory(), held, noise(1, 1, 1, 1)).empty());
}

/// The curve with this name, row, and side.
const MarginCurve& curve_of(const std::vector<MarginCurve>& curves, const std::string& name,
                            int row, bool upper) {
  for (const MarginCurve& curve : curves)
    if (curve.name == name && curve.row == row && curve.upper == upper) return curve;
  throw std::logic_error("there is no such curve: " + name);
}

// At x = 1 and u = 0, a row a x + b u has the variance (a + b K)² P + (b K)² N.
TEST(Margins, RowsAndConesUseTheirGradients) {
  const ShootingProblem free = scalar_problem();
  using Term = LinearCombination::Term;
  const Term state{1, false, 0, 0}, twice{2, false, 0, 0}, half{0.5, false, 0, 0},
      control{-1, true, 0, 0};
  const auto below = [&](double upper) {
    return testing::Added{.name = "below",
                          .residual = coordinate_residual(free.manifold(), {0}),
                          .reference = {0},
                          .lower = {-9},
                          .upper = {upper},
                          .first = 2,
                          .last = 2};
  };
  const ShootingProblem problem = testing::with_constraints(
      free, {{.name = "rows",
              .residual = combination_residual(
                  1, {{.terms = {state}}, {.terms = {twice, control}, .constant = 0.25}}),
              .lower = {-3, -4},
              .upper = {5, 6},
              .first = 1,
              .last = 1},
             {.name = "cone",
              .residual = combination_residual(
                  1, {{.terms = {state}, .constant = 0.3}, {.terms = {half}, .constant = 2}}),
              .kind = ConstraintKind::second_order_cone,
              .first = 2,
              .last = 3},
             below(2),
             below(1.5),
             below(1.75)});
  const auto curves = constraint_margins(problem, problem.create_trajectory(), scalar_gains(),
                                         noise(0.2, 0.1, 0.3, 1));
  double P[4] = {0.04};
  for (int k = 0; k < 3; ++k) P[k + 1] = 0.25 * P[k] + 0.16 * 0.09 + 0.01;
  const auto expect_margin = [&](const Margin& margin, int knot, double distance, double sigma) {
    EXPECT_EQ(margin.knot, knot);
    EXPECT_NEAR(margin.distance, distance, 1e-14);
    EXPECT_NEAR(margin.sigma, sigma, 1e-14);
  };
  const double second = std::sqrt(2.8 * 2.8 * P[1] + 0.64 * 0.09);
  expect_margin(curve_of(curves, "rows", 0, true).nodes.at(0), 1, 4, std::sqrt(P[1]));
  expect_margin(curve_of(curves, "rows", 0, false).nodes.at(0), 1, 4, std::sqrt(P[1]));
  expect_margin(curve_of(curves, "rows", 1, true).nodes.at(0), 1, 3.75, second);
  expect_margin(curve_of(curves, "rows", 1, false).nodes.at(0), 1, 6.25, second);
  const auto& cone = curve_of(curves, "cone", -1, true).nodes;
  ASSERT_EQ(cone.size(), 2u);
  for (int i = 0; i < 2; ++i) expect_margin(cone[i], 2 + i, 1.2, 0.5 * std::sqrt(P[2 + i]));
  // Among several rows at a node, the one with the fewest standard deviations counts.
  const auto& closest = curve_of(curves, "below", -1, true).nodes;
  ASSERT_EQ(closest.size(), 1u);
  expect_margin(closest[0], 2, 0.5, std::sqrt(P[2]));
  expect_margin(curve_of(curves, "below", -1, false).nodes.at(0), 2, 10, std::sqrt(P[2]));
  ASSERT_EQ(curves.size(), 9u);  // including both control bounds
  for (std::size_t i = 1; i < curves.size(); ++i)
    EXPECT_LE(curves[i - 1].smallest().steps(), curves[i].smallest().steps());
}

/// A double integrator brought to rest under bounds on control and speed.
ShootingProblem braked() {
  const ShootingProblem free =
      testing::tracking_problem(double_integrator(1), Integrator::rk4, 20, 0.1, {1, 0},
                                {{0, 0}, {1, 1}, {0.1}, {1, 1}}, -3, 3);
  return testing::with_constraints(free, {{.name = "speed",
                                           .residual = coordinate_residual(free.manifold(), {1}),
                                           .reference = {0},
                                           .lower = {-0.9},
                                           .upper = {0.9},
                                           .first = 1,
                                           .last = 20}});
}

/// Random runs of δx⁺ = A δx + B K (δx + n) + w, node by node.
class RandomRuns {
 public:
  RandomRuns(const Linearization& linear, const std::vector<Eigen::MatrixXd>& gains,
             const StateNoise& sigmas, int runs)
      : linear_(linear), gains_(gains), sigmas_(sigmas), runs_(runs), numbers_(5) {}

  /// Calls visit(node, δx, δu); δu is empty at the last node.
  template <class Visit>
  void run(Visit visit) {
    const Eigen::Index n = sigmas_.initial.size();
    for (int i = 0; i < runs_; ++i) {
      Eigen::VectorXd dx = drawn(sigmas_.initial);
      for (std::size_t k = 0; k < gains_.size(); ++k) {
        const Eigen::VectorXd du = gains_[k] * (dx + drawn(sigmas_.measurement));
        visit(static_cast<int>(k), dx, du);
        const Eigen::MatrixXd F = linear_.knots[k].dense_jacobian();
        dx = F.leftCols(n) * dx + F.rightCols(du.size()) * du + drawn(sigmas_.process);
      }
      visit(static_cast<int>(gains_.size()), dx, Eigen::VectorXd());
    }
  }

 private:
  Eigen::VectorXd drawn(const Eigen::VectorXd& sigma) {
    Eigen::VectorXd v(sigma.size());
    for (Eigen::Index i = 0; i < v.size(); ++i) v[i] = sigma[i] * numbers_.next();
    return v;
  }

  const Linearization& linear_;
  const std::vector<Eigen::MatrixXd>& gains_;
  const StateNoise& sigmas_;
  int runs_;
  NormalNumbers numbers_;
};

// The relative standard deviation of a variance from n samples is √(2/n), that of a frequency √(p
// (1 − p)/n). The test allows three of them.
TEST(Margins, MatchMonteCarloRunsOfLinearLoop) {
  constexpr int kRuns = 20'000;
  const ShootingProblem problem = braked();
  const SolveResult plan =
      solve(problem, "altro", testing::tight_options(), problem.create_trajectory());
  ASSERT_EQ(plan.status, SolveStatus::converged) << plan.message;
  const StateNoise sigmas = noise(0.05, 0.02, 0.03, 2);
  Linearization linear(problem);
  Evaluator(problem).differentiate(plan.trajectory, linear);
  const auto P = propagate_covariance(problem, linear, plan.feedback.K, sigmas);
  std::vector<Eigen::MatrixXd> sums(21, Eigen::MatrixXd::Zero(2, 2));
  std::vector<int> too_fast(21, 0), too_strong(20, 0);
  RandomRuns(linear, plan.feedback.K, sigmas, kRuns)
      .run([&](int k, const Eigen::VectorXd& dx, const Eigen::VectorXd& du) {
        sums[k] += dx * dx.transpose();
        too_fast[k] += plan.trajectory.x(k)[1] + dx[1] < -0.9;
        if (k < 20) too_strong[k] += plan.trajectory.u(k)[0] + du[0] < -3;
      });
  for (int k = 0; k <= 20; ++k)
    for (int i = 0; i < 2; ++i)
      EXPECT_NEAR(sums[k](i, i) / kRuns, P[k](i, i), 3 * std::sqrt(2.0 / kRuns) * P[k](i, i))
          << k << ' ' << i;
  int compared = 0;
  for (const MarginCurve& curve :
       constraint_margins(problem, plan.trajectory, plan.feedback.K, sigmas)) {
    if (curve.upper) continue;
    const std::vector<int>& count = curve.name == "speed" ? too_fast : too_strong;
    for (const Margin& node : curve.nodes) {
      const double p = node.probability();
      EXPECT_NEAR(static_cast<double>(count[node.knot]) / kRuns, p,
                  3 * std::sqrt(p * (1 - p) / kRuns) + 1e-12)
          << curve.name << ' ' << node.knot;
      ++compared;
    }
  }
  EXPECT_GE(compared, 35);
}

}  // namespace
}  // namespace conddp
