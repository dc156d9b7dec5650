// Costates and gradients, compared with derivatives of costs rolled out independently of the
// solvers.
#include "solvers/riccati/adjoint.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include "support/dense_horizon.hpp"
#include "support/linear_quadratic.hpp"
#include "support/plain_pendulum.hpp"

namespace conddp::testing {
namespace {

using Complex = std::complex<double>;

/// A pendulum iterate with gaps and a policy, and complex-step derivatives of its cost.
struct PendulumIterate {
  explicit PendulumIterate(unsigned seed, bool with_gains, bool with_gaps, double limit = kFree)
      : problem([&] {
          plain.limit = limit;
          return plain.problem();
        }()),
        bounds(problem),
        linearization(problem),
        gaps(problem),
        adjoint(problem, bounds),
        feedback(problem),
        trajectory(problem.create_trajectory()) {
    RandomNumbers random(seed);
    for (int k = 0; k < plain.knots; ++k) {
      trajectory.u(k)[0] = random.uniform(-3, 3);
      if (with_gains) feedback.K[k] << random.uniform(-5, 5), random.uniform(-2, 2);
    }
    bounds.clamp(trajectory);
    for (int k = 0; k < plain.knots; ++k) {
      const Eigen::Vector2d next = plain.next<double>(trajectory.x(k), trajectory.u(k)[0]);
      trajectory.x(k + 1) = next;
      if (with_gaps) trajectory.x(k + 1) += Eigen::Vector2d(random.uniform(-1, 1), 0.2);
    }
    evaluator().differentiate(trajectory, linearization);
    gaps.set(linearization, true);
    adjoint.compute(linearization, trajectory, gaps, feedback);
  }
  Evaluator& evaluator() {
    if (!evaluator_) evaluator_ = std::make_unique<Evaluator>(problem);
    return *evaluator_;
  }

  /// Derivative of the cost from node `first` with respect to that node's state (entry), the
  /// policy's v of a knot, or the common closing of all gaps.
  enum class By { state, control, gaps };
  double derivative(By by, int first, int entry = 0) const {
    const Complex step(0, 1e-30);
    std::vector<Complex> v;
    std::vector<Eigen::RowVector2d> K;
    std::vector<Eigen::Vector2d> nominal;
    std::vector<PlainPendulum::State<Complex>> offset;
    for (int k = 0; k < plain.knots; ++k) {
      const double u = trajectory.u(k)[0];
      v.emplace_back(u);
      const bool follows = std::abs(u) < plain.limit;
      K.push_back(follows ? Eigen::RowVector2d(feedback.K[k]) : Eigen::RowVector2d::Zero());
      nominal.emplace_back(trajectory.x(k));
      const Eigen::Vector2d gap = plain.next<double>(trajectory.x(k), u) - trajectory.x(k + 1);
      offset.push_back(gap.cast<Complex>() * (by == By::gaps ? step - 1.0 : Complex(-1)));
    }
    PlainPendulum::State<Complex> x = trajectory.x(first).cast<Complex>();
    if (by == By::state) x[entry] += step;
    if (by == By::control) v[first] += step;
    return plain.cost_to_go<Complex>(first, x, v, K, nominal, offset).imag() / step.imag();
  }

  PlainPendulum plain;
  ShootingProblem problem;
  ControlBounds bounds;
  Linearization linearization;
  Gaps gaps;
  Adjoint adjoint;
  Feedback feedback;
  Trajectory trajectory;

 private:
  std::unique_ptr<Evaluator> evaluator_;
};

using By = PendulumIterate::By;

TEST(Adjoint, GradientFollowsTheCostAlongThePolicy) {
  for (const unsigned seed : {1u, 2u, 3u})
    for (const bool gains : {false, true})
      for (const bool open : {false, true}) {
        SCOPED_TRACE(fmt::format("seed {}, gains {}, gaps {}", seed, gains, open));
        const PendulumIterate at(seed, gains, open);
        for (int k = 0; k < at.plain.knots; ++k) {
          EXPECT_NEAR(at.adjoint.gradient()[k], at.derivative(By::control, k), 1e-11) << k;
          for (int i = 0; i < 2; ++i)
            EXPECT_NEAR(at.adjoint.costates()(i, k), at.derivative(By::state, k, i), 1e-11) << k;
        }
        EXPECT_NEAR(at.adjoint.gap_slope(), at.derivative(By::gaps, 0), 1e-11);
        EXPECT_EQ(at.adjoint.gap_slope() != 0, open);
      }
}

TEST(Adjoint, ControlsAtABoundIgnoreThePolicy) {
  int at_bound = 0;
  for (const unsigned seed : {1u, 2u, 3u}) {
    const PendulumIterate at(seed, true, true, 2);
    for (int k = 0; k < at.plain.knots; ++k) {
      const double expected = at.derivative(By::control, k);
      const bool follows = std::abs(at.trajectory.u(k)[0]) < 2;
      at_bound += !follows;
      EXPECT_NEAR(at.adjoint.gradient()[k], expected, 1e-11) << k;
      EXPECT_NEAR(at.adjoint.followed_gradient()[k], follows ? expected : 0, 1e-11) << k;
      for (int i = 0; i < 2; ++i)
        EXPECT_NEAR(at.adjoint.costates()(i, k), at.derivative(By::state, k, i), 1e-11) << k;
    }
  }
  EXPECT_GT(at_bound, 2);
}

// ∇_x L = ℓ_x + f_xᵀ λ⁺ − λ, independent of the policy.
TEST(Adjoint, StateGradientIsLagrangianMinusCostates) {
  const PendulumIterate at(4, true, true);
  for (int k = 0; k < at.plain.knots; ++k) {
    const Eigen::Vector2d x = at.trajectory.x(k);
    const Eigen::Vector2d expected =
        at.plain.stage_gradient(x, at.trajectory.u(k)[0]).head<2>() +
        at.plain.jacobian(x).leftCols<2>().transpose() * at.adjoint.costates().col(k + 1) -
        at.adjoint.costates().col(k);
    EXPECT_LT((at.adjoint.state_gradient().col(k) - expected).norm(), 1e-12) << k;
    EXPECT_GT(expected.norm(), 1e-3) << k;
  }
  EXPECT_EQ(at.adjoint.state_gradient().col(at.plain.knots).norm(), 0);
}

// Without gains, the costates solve the dense system Eᵀλ = −g in the state columns.
TEST(Adjoint, CostatesSolveTransposedLinearDynamics) {
  for (const unsigned seed : {1u, 2u, 3u}) {
    const LinearQuadratic lq(1, 2 + static_cast<int>(seed), {1, 3}, 3, -kFree, kFree);
    const ShootingProblem& problem = *lq.problem;
    const ControlBounds bounds(problem);
    Linearization linearization(problem);
    RandomNumbers random(seed);
    randomize(problem, random, linearization);
    Gaps gaps(problem);
    gaps.set(linearization, true);
    Adjoint adjoint(problem, bounds);
    for (int again = 0; again < 2; ++again)  // earlier results leave no trace
      adjoint.compute(linearization, random_guess(problem, seed), gaps, Feedback(problem));
    const DenseHorizon dense(linearization, true);
    const int ndx = dense.ndx, n = ndx * dense.nodes();
    Eigen::MatrixXd states(n, n);  // state rows of Eᵀ
    Eigen::VectorXd gradient(n);
    for (int k = 0; k < dense.nodes(); ++k) {
      states.middleRows(k * ndx, ndx) = dense.E.middleCols(dense.offset[k], ndx).transpose();
      gradient.segment(k * ndx, ndx) = dense.g.segment(dense.offset[k], ndx);
    }
    const Eigen::VectorXd lambda = states.fullPivLu().solve(-gradient);
    EXPECT_LT((adjoint.costates().reshaped() - lambda).lpNorm<Eigen::Infinity>(), 1e-11);
    EXPECT_LT((adjoint.gradient() - dense.S.transpose() * dense.g).lpNorm<Eigen::Infinity>(),
              1e-11);
    EXPECT_NEAR(adjoint.gap_slope(), lambda.dot(-dense.e), 1e-11);
  }
}

// A sum of costs |3| + |−5| and two states with costates 2 and −7: the rounding of 8 + 2·10 +
// 7·100.
TEST(Adjoint, CostRoundingIncludesTermsAndStates) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem problem =
      tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)), Integrator::discrete, 2,
                       1, {1}, {{0}, {1}, {1}, {1}, false});
  const ControlBounds bounds(problem);
  Linearization linearization(problem);
  linearization.cost << 3, -5, 0;
  linearization.knots[0].gradient << 1000, 0;
  linearization.knots[1].gradient << 9, 0;
  linearization.knots[2].gradient << -7;
  for (int k = 0; k < 2; ++k) linearization.knots[k].F << 1, 1;
  Trajectory trajectory = problem.create_trajectory();
  trajectory.x(0)[0] = 1e9;
  trajectory.x(1)[0] = -10;
  trajectory.x(2)[0] = 100;
  Adjoint adjoint(problem, bounds);
  adjoint.compute(linearization, trajectory, Gaps(problem), Feedback(problem));
  EXPECT_DOUBLE_EQ(adjoint.cost_rounding(linearization, trajectory),
                   728 * std::numeric_limits<double>::epsilon());
}

/// Gradient of the costs + νᵀ (rows) along the gains of the costs' own Riccati recursion.
Eigen::VectorXd gradient_along_plain_gains(const LinearQuadratic& lq, const Trajectory& t,
                                           const std::vector<Eigen::VectorXd>& row_gradient) {
  const auto gains = lq.riccati_gains();
  const int N = lq.N(), nx = lq.nx;
  Eigen::VectorXd lambda = lq.Qf.cwiseProduct(t.x(N) - lq.xf_ref) + row_gradient[N];
  std::vector<Eigen::VectorXd> parts(N);
  int n = 0;
  for (int k = N - 1; k >= 0; --k) {
    const LinearQuadratic::Knot& knot = lq.knots[k];
    parts[k] = knot.R.cwiseProduct(t.u(k)) + row_gradient[k].tail(knot.B.cols()) +
               knot.B.transpose() * lambda;
    lambda = knot.Q.cwiseProduct(t.x(k) - knot.x_ref) + row_gradient[k].head(nx) +
             knot.A.transpose() * lambda + gains[k].transpose() * parts[k];
    n += static_cast<int>(parts[k].size());
  }
  Eigen::VectorXd all(n);
  for (int k = 0, at = 0; k < N; at += static_cast<int>(parts[k].size()), ++k)
    all.segment(at, parts[k].size()) = parts[k];
  return all;
}

TEST(PlainAdjoint, StationarityUsesTheGainsOfCostsOnly) {
  for (const unsigned seed : {1u, 2u, 3u, 4u}) {
    SCOPED_TRACE(fmt::format("seed {}", seed));
    const LinearQuadratic lq(seed, 3, {2}, 4, -kFree, kFree);
    RandomNumbers random(seed);
    Eigen::MatrixXd C(2, 5), end(1, 3);
    for (double& entry : C.reshaped()) entry = random.uniform(-1, 1);
    for (double& entry : end.reshaped()) entry = random.uniform(-1, 1);
    const ShootingProblem problem = with_constraints(
        *lq.problem,
        {affine_rows(C, *lq.problem, 0, 3, -1, 1), affine_rows(end, *lq.problem, 4, 4, 0, 0)});
    Trajectory trajectory = random_guess(problem, seed);
    Eigen::VectorXd nu(problem.constraint_rows());
    for (double& entry : nu) entry = random.uniform(-2, 2);
    std::vector<Eigen::VectorXd> row_gradient;
    for (int k = 0; k < 4; ++k) row_gradient.emplace_back(C.transpose() * nu.segment(2 * k, 2));
    row_gradient.emplace_back(end.transpose() * nu.tail(1));

    const ControlBounds bounds(problem);
    Evaluator evaluator(problem);
    Linearization linearization(problem);
    evaluator.differentiate(trajectory, linearization);
    Gaps gaps(problem);
    gaps.set(linearization, true);
    PlainAdjoint plain(problem, bounds);
    const std::optional<double> found = plain.stationarity(evaluator, trajectory, gaps, nu);
    ASSERT_TRUE(found);
    const Eigen::VectorXd expected = gradient_along_plain_gains(lq, trajectory, row_gradient);
    EXPECT_NEAR(*found, expected.lpNorm<Eigen::Infinity>(), 1e-10);
  }
}

TEST(PlainAdjoint, DoesNotExistWithoutAMinimumOfCosts) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const auto stationarity = [&](double weight) {
    const ShootingProblem problem =
        tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)), Integrator::discrete, 2,
                         1, {1}, {{0}, {0}, {weight}, {0}, false});
    const ControlBounds bounds(problem);
    Evaluator evaluator(problem);
    PlainAdjoint plain(problem, bounds);
    return plain.stationarity(evaluator, constant_controls(problem, 1), Gaps(problem),
                              Eigen::VectorXd(0));
  };
  EXPECT_FALSE(stationarity(-4 * SolverOptions::Regularization::kLargest));
  // A regularized minimum exists. The gradient −4 u excludes the regularization.
  const auto found = stationarity(-4);
  ASSERT_TRUE(found);
  EXPECT_DOUBLE_EQ(*found, 4);
}

}  // namespace
}  // namespace conddp::testing
