// Initial multipliers, compared with the equations of weighted least squares.
#include "nlp/first_multipliers.hpp"

#include <cmath>
#include <limits>

#include "nlp/chain_factorization.hpp"
#include "nlp/transcription.hpp"
#include "support/constrained_problems.hpp"
#include "support/expression_systems.hpp"
#include "support/nlp_derivatives.hpp"

namespace conddp {
namespace {

using testing::jacobian_times;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A program at its guess.
struct First {
  explicit First(const ShootingProblem& of)
      : problem(of), evaluator(of, 1), program(of, evaluator, {}) {
    std::mt19937_64 engine(3);
    Trajectory guess = problem.create_trajectory();
    for (int k = 0; k < problem.knots(); ++k) {
      guess.u(k) = testing::random_vector(problem.nu(k), engine);
      guess.x(k + 1) = guess.x(k) + 0.1 * testing::random_vector(problem.nx(), engine);
    }
    program.set_center(guess);
    y = program.point_of(guess);
    program.set_point(y.data());
  }
  /// ∂L/∂y with unit multipliers for all variable bounds, and with first multipliers where every
  /// third variable has this weight.
  Eigen::VectorXd slope(double weight) {
    weights = Eigen::VectorXd::Ones(program.variables());
    for (int i = 0; i < weights.size(); i += 3) weights[i] = weight;
    const auto found = first_multipliers(program, weights, ChainFactorization::make);
    EXPECT_TRUE(found);
    rows = found.value_or(Eigen::VectorXd::Zero(program.rows()));
    return testing::lagrangian_gradient(program, 1, rows) - force(program.lower(), program.upper());
  }
  static Eigen::VectorXd force(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper) {
    Eigen::VectorXd sum = Eigen::VectorXd::Zero(lower.size());
    for (int i = 0; i < sum.size(); ++i) {
      if (lower[i] == upper[i]) continue;
      if (std::isfinite(lower[i])) sum[i] += 1;
      if (std::isfinite(upper[i])) sum[i] -= 1;
    }
    return sum;
  }

  const ShootingProblem& problem;
  Evaluator evaluator;
  Transcription program;
  Eigen::VectorXd y, weights, rows;
};

TEST(FirstMultipliers, SolveTheWeightedLeastSquaresEquations) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    First first(problem);
    const Eigen::VectorXd slope = first.slope(7);
    Eigen::VectorXd left = jacobian_times(first.program, first.weights.cwiseProduct(slope), false);
    left += First::force(first.program.row_lower(), first.program.row_upper());
    for (int row = 0; row < left.size(); ++row)
      if (first.program.row_lower()[row] < first.program.row_upper()[row])
        left[row] += first.rows[row];
    EXPECT_LE(left.lpNorm<Eigen::Infinity>(), 1e-9 * slope.lpNorm<Eigen::Infinity>()) << name;
  }
}

/// Moves x by u and integrates `rate` in c, whose terminal value costs 3 per unit.
ShootingProblem with_cost_state(const std::string& rate_of_x, const std::string& rate) {
  const auto system = expression_system({.kind = SystemKind::first_order,
                                         .states = expression_numbers({"x", "c"}),
                                         .controls = expression_columns({"u"}),
                                         .equations = {{"x", rate_of_x}, {"c", rate}}});
  Phase phase = testing::tracking_phase(system, Integrator::rk4, 4, 0.1, {{0, 0}, {0, 0}, {0}, {}},
                                        -kInfinity, kInfinity);
  auto model = std::make_shared<KnotModel>(system, Integrator::none);
  model->add_cost("end", coordinate_residual(system->manifold(), {1}),
                  {.kind = ActivationKind::linear});
  return {{1, 0},
          {std::move(phase)},
          {.name = "end", .model = model, .dt = {0}, .cost_scale = {1}, .parameters = {0, 3}}};
}

TEST(FirstMultipliers, CostateOfACostIsItsTerminalSlope) {
  const ShootingProblem problem = with_cost_state("u - x^3", "x^2 + u^2");
  First first(problem);
  const Eigen::VectorXd weights = first.program.weights_of_cost_states(1e8);
  EXPECT_EQ((weights.array() == 1e8).count(), problem.knots());
  const auto rows = first_multipliers(first.program, weights, ChainFactorization::make);
  ASSERT_TRUE(rows);
  EXPECT_EQ((rows->array().abs() - 3)
                .abs()
                .cwiseMin(1)
                .unaryExpr([](double far) { return far < 1e-6 ? 1 : 0; })
                .sum(),
            problem.knots());
}

TEST(FirstMultipliers, SharedOrLinearStatesAreNotWeighted) {
  const std::vector<std::pair<std::string, std::string>> rates = {{"u - c", "x^2 + u^2"},
                                                                  {"u - x", "x + u"}};
  for (const auto& [of_x, of_c] : rates) {
    const ShootingProblem problem = with_cost_state(of_x, of_c);
    First first(problem);
    EXPECT_EQ(first.program.weights_of_cost_states(1e8).maxCoeff(), 1) << of_c;
  }
}

TEST(FirstMultipliers, DoNotExistForNonFiniteDerivatives) {
  const ShootingProblem problem = testing::cartpole_swing_up(20);
  First first(problem);
  first.y[5] = std::numeric_limits<double>::quiet_NaN();
  first.program.set_point(first.y.data());
  EXPECT_FALSE(first_multipliers(first.program, Eigen::VectorXd::Ones(first.y.size()),
                                 ChainFactorization::make));
}

}  // namespace
}  // namespace conddp
