// Multipliers to begin with, against the equations of weighted least squares.
#include "nlp/first_multipliers.hpp"

#include <cmath>
#include <limits>

#include "nlp/chain_factorization.hpp"
#include "nlp/transcription.hpp"
#include "support/constrained_problems.hpp"
#include "support/nlp_derivatives.hpp"

namespace conddp {
namespace {

using testing::jacobian_times;

/// A program at its guess, with the multipliers by which states count so much.
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
  }
  /// ∂L/∂y where all bounds of variables have multipliers of 1.
  Eigen::VectorXd slope(double weight) {
    weights = program.weights_of_states(weight);
    const auto found = first_multipliers(program, y, weights, ChainFactorization::make);
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

TEST(FirstMultipliers, SolveTheEquationsOfWeightedLeastSquares) {
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

TEST(FirstMultipliers, AreCostatesWhereStatesCountMost) {
  const ShootingProblem problem = testing::cartpole_swing_up(20);
  First first(problem);
  const auto of_states = [&](const Eigen::VectorXd& slope) {
    const Eigen::ArrayXd is_state = (first.weights.array() > 1).cast<double>();
    return (slope.array() * is_state).abs().maxCoeff();
  };
  const double least = of_states(first.slope(2));
  EXPECT_LE(of_states(first.slope(1e10)), 1e-6 * least);
}

TEST(FirstMultipliers, AreNoneWhereDerivativesAreNotFinite) {
  const ShootingProblem problem = testing::cartpole_swing_up(20);
  First first(problem);
  first.y[5] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(first_multipliers(first.program, first.y, first.program.weights_of_states(7),
                                 ChainFactorization::make));
}

}  // namespace
}  // namespace conddp
