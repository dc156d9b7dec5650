#include "analysis/certificate/lagrangian_gradient.hpp"

#include <gtest/gtest.h>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/replay.hpp"
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

}  // namespace
}  // namespace conddp
