#include "analysis/certificate/lagrangian_gradient.hpp"

#include <gtest/gtest.h>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/gains_check.hpp"
#include "analysis/certificate/replay.hpp"
#include "analysis/certificate/solution_claims.hpp"
#include "analysis/derivatives/node_models.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/constrained_problems.hpp"
#include "support/small_problems.hpp"

namespace conddp {
namespace {

/// Σ cost + Σ λ_{k+1}ᵀ (f ⊕ (−gap) ⊖ x_{k+1}) in scalar arithmetic.
double lagrangian(const ShootingProblem& problem, const Trajectory& t, const Eigen::MatrixXd& gap,
                  const Eigen::MatrixXd& costates) {
  double sum = 0;
  const int n = problem.ndx();
  for (int k = 0; k <= problem.knots(); ++k) {
    const KnotView& view = problem.knot(k);
    KnotWorkspace<double> work(*view.model);
    const double* u = k < problem.knots() ? t.u(k).data() : nullptr;
    view.model->evaluate(
        KnotInput<double>{t.x(k).data(), u, view.parameters, view.dt, view.cost_scale}, work);
    sum += work.cost;
    if (k == problem.knots()) break;
    const Eigen::VectorXd back = -gap.col(k);
    std::vector<double> closed(problem.nx());
    Eigen::VectorXd off(n);
    problem.manifold().integrate(work.next().data(), back.data(), closed.data());
    problem.manifold().difference(t.x(k + 1).data(), closed.data(), off.data());
    sum += costates.col(k + 1).dot(off);
  }
  return sum;
}

/// x ← x ⊕ δ.
template <class State>
void move_state(const ShootingProblem& problem, State x, const Eigen::VectorXd& delta) {
  problem.manifold().integrate(x.data(), delta.data(), x.data());
}

/// Compared with finite differences at a trajectory with open gaps, on flat and curved spaces.
TEST(LagrangianGradient, IsTheDerivativeOfTheLagrangian) {
  const ShootingProblem problems[] = {testing::cartpole_swing_up(), testing::quadrotor_move()};
  for (const ShootingProblem& problem : problems) {
    std::srand(1);
    Trajectory t = problem.create_trajectory();
    Eigen::MatrixXd gap(problem.ndx(), problem.knots());
    for (int k = 0; k <= problem.knots(); ++k) {
      move_state(problem, t.x(k), 0.3 * Eigen::VectorXd::Random(problem.ndx()));
      if (k < problem.knots()) t.u(k).setRandom();
    }
    for (int k = 0; k < problem.knots(); ++k) {
      const KnotView& view = problem.knot(k);
      KnotWorkspace<double> work(*view.model);
      view.model->evaluate(KnotInput<double>{t.x(k).data(), t.u(k).data(), view.parameters, view.dt,
                                             view.cost_scale},
                           work);
      problem.manifold().difference(t.x(k + 1).data(), work.next().data(), gap.col(k).data());
    }
    const Eigen::MatrixXd costates = Eigen::MatrixXd::Random(problem.ndx(), problem.knots() + 1);
    const Eigen::VectorXd none = Eigen::VectorXd::Zero(problem.constraint_rows());
    const LagrangianGradient gradient =
        lagrangian_gradient(problem, node_derivatives(problem, t, gap), costates, none);
    constexpr double kStep = 1e-6;
    for (const int k : {0, 1, problem.knots() / 2, problem.knots()}) {
      const auto slope = [&](auto move) {
        double value[2];
        for (int side = 0; side < 2; ++side) {
          Trajectory moved = t;
          move(moved, side == 0 ? -kStep : kStep);
          // x_k also enters the preceding step, which keeps its gap.
          value[side] = lagrangian(problem, moved, gap, costates);
        }
        return (value[1] - value[0]) / (2 * kStep);
      };
      for (int i = 0; i < problem.ndx(); ++i) {
        const double expected = slope([&](Trajectory& m, double h) {
          move_state(problem, m.x(k), h * Eigen::VectorXd::Unit(problem.ndx(), i));
        });
        // x_0 is fixed: only the recursion gives a costate equation for it.
        const double own = k == 0 ? expected - costates(i, 0) : expected;
        EXPECT_NEAR(gradient.state(i, k), own, 1e-6 * (1 + std::abs(own))) << k << " " << i;
      }
      if (k == problem.knots()) continue;
      for (int i = 0; i < problem.nu(k); ++i) {
        const double expected = slope([&](Trajectory& m, double h) { m.u(k)[i] += h; });
        EXPECT_NEAR(gradient.control[k][i], expected, 1e-6 * (1 + std::abs(expected)));
      }
    }
  }
}

/// Rounding of an entry is relative to the sum of magnitudes, regardless of cancellation.
TEST(LagrangianGradient, SizesSumTheAbsoluteTerms) {
  const ShootingProblem free = testing::cartpole_swing_up();
  const ShootingProblem problem = testing::with_constraints(
      free, {testing::goal_constraint(free, std::vector<double>(free.nx(), 0.0))});
  std::srand(2);
  Trajectory t = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k) {
    t.x(k).setRandom();
    t.u(k).setRandom();
  }
  const int N = problem.knots(), ndx = problem.ndx();
  const Eigen::MatrixXd costates = Eigen::MatrixXd::Random(ndx, N + 1);
  const Eigen::VectorXd multipliers = Eigen::VectorXd::Random(problem.constraint_rows());
  const auto derivatives = node_derivatives(problem, t, Eigen::MatrixXd::Zero(ndx, N));
  const LagrangianGradient gradient =
      lagrangian_gradient(problem, derivatives, costates, multipliers);
  for (int k = 0; k <= N; ++k) {
    const NodeDerivatives& node = derivatives[k];
    Eigen::VectorXd expected = node.cost.cwiseAbs();
    if (k < N) expected += node.step.cwiseAbs().transpose() * costates.col(k + 1).cwiseAbs();
    if (k == N) expected += node.constraint.cwiseAbs().transpose() * multipliers.cwiseAbs();
    const Eigen::VectorXd of_state = expected.head(ndx) + costates.col(k).cwiseAbs();
    EXPECT_LT((gradient.state_size.col(k) - of_state).norm(), 1e-12 * of_state.norm()) << k;
    if (k == N) continue;
    const Eigen::VectorXd of_control = expected.tail(problem.nu(k));
    EXPECT_LT((gradient.control_size[k] - of_control).norm(), 1e-12 * of_control.norm()) << k;
  }
}

/// With its planned time step, a motion reproduces itself.
TEST(Replay, PlanGridReproducesThePlan) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  const SolveResult result =
      solve(problem, "box_fddp", {}, testing::constant_controls(problem, 0.01));
  ASSERT_EQ(result.status, SolveStatus::converged);
  const Replay same = replay(problem, result.trajectory, result.feedback.K, 1);
  EXPECT_LE(same.controls.deviation, 1e-8);
  EXPECT_LE(same.feedback.deviation, 1e-10);
  const Replay finer = replay(problem, result.trajectory, result.feedback.K);
  EXPECT_EQ(finer.substeps, 10);
  EXPECT_GT(finer.controls.deviation, finer.feedback.deviation);
  EXPECT_GE(finer.feedback.knot, 0);
}

TEST(Replay, ReportsWhereTheMotionIsLost) {
  const ShootingProblem problem = testing::cartpole_swing_up();
  Trajectory wild = problem.create_trajectory();
  wild.u(3).setConstant(1e300);
  std::vector<Eigen::MatrixXd> gains(problem.knots(), Eigen::MatrixXd::Zero(1, problem.ndx()));
  const Replay lost = replay(problem, wild, gains);
  EXPECT_EQ(lost.controls.lost_at, 3);
  wild.x(2)[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(replay(problem, wild, gains).impossible.empty());
}

/// One step x⁺ = x + u from the origin with cost ½ (x⁺ − 1)² + ½ u²: the optimum is u = ½, the gain
/// is −½, and Q_uu = 2.
ShootingProblem one_step(double low = -testing::kFree, double up = testing::kFree) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  return testing::tracking_problem(linear_system(one, one, Eigen::VectorXd::Zero(1)),
                                   Integrator::discrete, 1, 1, {0}, {{1}, {0}, {1}, {1}, false},
                                   low, up);
}

Trajectory simulated(const ShootingProblem& problem, double control) {
  Trajectory trajectory = testing::constant_controls(problem, control);
  Evaluator(problem).simulate(trajectory);
  return trajectory;
}

std::vector<NodeDerivatives> derivatives_of(const ShootingProblem& problem,
                                            const Trajectory& trajectory) {
  return node_derivatives(problem, trajectory, Eigen::MatrixXd::Zero(1, 1));
}

// From u to the optimum ½, the cost falls by (u − ½)², since its second derivative is 2.
TEST(RiccatiPolicy, ExpectedDecreaseIsExactForQuadraticCosts) {
  const ShootingProblem problem = one_step();
  for (const double u : {0.0, 0.2, 2.0}) {
    const Trajectory trajectory = simulated(problem, u);
    const auto derivatives = derivatives_of(problem, trajectory);
    const RiccatiPolicy policy = riccati_policy(problem, trajectory, derivatives,
                                                gauss_newton_hessians(problem, trajectory));
    EXPECT_NEAR(policy.K[0](0, 0), -0.5, 1e-15);
    const AdjointPass pass = adjoint_pass(problem, derivatives, {}, policy.K);
    EXPECT_NEAR(pass.control[0][0], 2 * u - 1, 1e-15);
    EXPECT_NEAR(policy.decrease(pass.control), (u - 0.5) * (u - 0.5), 1e-15);
  }
}

// A control at its lower bound is stationary if the cost rises with it, and vice versa at the upper
// bound.
TEST(ProjectedGradient, BoundBlocksDescentAcrossItself) {
  const ShootingProblem problem = one_step(-1, 1);
  const auto projected = [&](double u, double gradient) {
    return project(problem, simulated(problem, u), {Eigen::VectorXd::Constant(1, gradient)});
  };
  EXPECT_EQ(projected(-1, 3).stationarity, 0);
  EXPECT_EQ(projected(-1, -3).stationarity, 3);
  EXPECT_EQ(projected(1, -3).stationarity, 0);
  EXPECT_EQ(projected(1, 3).stationarity, 3);
  EXPECT_EQ(projected(0, 3).stationarity, 3);
  EXPECT_EQ(projected(0, -3).stationarity, 3);
  // Outside the bounds, the multiplier is not complementary.
  EXPECT_EQ(projected(-1.5, 3).product, 1.5);
  EXPECT_EQ(projected(1.5, -3).product, 1.5);
}

// A value counts as at its bound within rounding, relative to the bound or to 1, or within the
// tolerance.
TEST(ProjectedGradient, BoundIsMetToRounding) {
  const ShootingProblem problem = one_step(-3, 3);
  const auto stationarity = [&](double u, double gradient, double tolerance) {
    return project(problem, simulated(problem, u), {Eigen::VectorXd::Constant(1, gradient)},
                   tolerance)
        .stationarity;
  };
  for (const double side : {-1.0, 1.0}) {
    const double push = -2 * side;
    EXPECT_EQ(stationarity(side * (3 - 2e-14), push, kBoundRounding), 0);
    EXPECT_EQ(stationarity(side * (3 - 1e-13), push, kBoundRounding), 2);
    EXPECT_EQ(stationarity(side * (3 - 2e-6), push, 1e-6), 0);
    EXPECT_EQ(stationarity(side * (3 - 4e-6), push, 1e-6), 2);
  }
  const ShootingProblem narrow = one_step(-0.5, 0.5);
  for (const double side : {-1.0, 1.0})
    EXPECT_EQ(project(narrow, simulated(narrow, side * (0.5 - 9e-7)),
                      {Eigen::VectorXd::Constant(1, -side)}, 1e-6)
                  .stationarity,
              0);
}

// A control at its bound without a multiplier may be free or held, as the sweep decides.
TEST(GainsCheck, InactiveBoundMayBeHeldOrFree) {
  const ShootingProblem problem = one_step(-1, 0.5);
  SolutionClaims claims(problem);
  claims.trajectory = simulated(problem, 0.5);
  claims.gain_regularization = 0;
  const auto feedback_holds = [&](double gain) {
    claims.gains[0].setConstant(gain);
    const auto derivatives = derivatives_of(problem, claims.trajectory);
    const auto hessians = gauss_newton_hessians(problem, claims.trajectory);
    const auto checks =
        check_gains(problem, claims, derivatives, hessians, Eigen::MatrixXd::Zero(1, 1));
    EXPECT_EQ(checks.size(), 2u);
    return checks.at(0).holds;
  };
  EXPECT_TRUE(feedback_holds(-0.5));
  EXPECT_TRUE(feedback_holds(0));
  EXPECT_FALSE(feedback_holds(-0.4));
}

// Two terms of ∇_u L change by 1e-13 relative, and so does the costate in one of them. For one sign
// of f_u, all changes add up.
TEST(AdjointPass, RoundingSumsAllTermsOfTheGradient) {
  const ShootingProblem problem = one_step();
  const Eigen::VectorXd none(0);
  for (const double effort : {0.5, 8.0}) {
    double most = 0;
    for (const double slope : {-3.0, 3.0}) {
      std::vector<NodeDerivatives> derivatives(2);
      derivatives[0] = {Eigen::Vector2d(0, effort), Eigen::MatrixXd(0, 2),
                        Eigen::RowVector2d(1, slope)};
      derivatives[1] = {Eigen::VectorXd::Constant(1, 2), Eigen::MatrixXd(0, 1), {}};
      const AdjointPass pass = adjoint_pass(problem, derivatives, none, {});
      EXPECT_EQ(pass.control[0][0], effort + 2 * slope);
      most = std::max(most, pass.rounding);
    }
    EXPECT_NEAR(most, kAdjointRounding * (effort + 2 * 3 * 2), 1e-3 * kAdjointRounding);
  }
}

}  // namespace
}  // namespace conddp
