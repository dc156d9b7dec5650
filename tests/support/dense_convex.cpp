#include "support/dense_convex.hpp"

#include <algorithm>
#include <cmath>

#include <gtest/gtest.h>

namespace conddp::testing {
namespace {

Eigen::VectorXd values_at(const ShootingProblem& problem, Evaluator& evaluator,
                          const Eigen::VectorXd& U) {
  Trajectory t = problem.create_trajectory();
  int at = 0;
  for (int k = 0; k < problem.knots(); ++k) {
    t.u(k) = U.segment(at, problem.nu(k));
    at += problem.nu(k);
  }
  EXPECT_EQ(evaluator.simulate(t), -1);
  Evaluation evaluation(problem);
  evaluator.evaluate(t, evaluation);
  return evaluation.constraint;
}

/// Share of the way from s to its nearest point in the set that ADMM goes with penalty 1: the whole
/// way for hard constraints, the proximal step of the penalty for soft ones.
double share_of_way(const ShootingProblem& problem, const NodeConstraint& c, double distance) {
  if (!c.is_soft() || distance == 0) return 1;
  const KnotView& knot = problem.knot(c.node);
  const double weight = knot.cost_scale * knot.parameters[c.term->weight()];
  return c.term->softness == Softness::l1 ? std::min(1.0, weight / distance)
                                          : weight / (weight + 1);
}

void move_towards(const ShootingProblem& problem, const NodeConstraint& c, const Eigen::VectorXd& s,
                  Eigen::VectorXd& z) {
  const int n = c.term->rows;
  if (c.term->has_bounds()) {
    for (int i = 0; i < n; ++i) {
      const double off = s[c.row + i] - std::clamp(s[c.row + i], c.lower[i], c.upper[i]);
      z[c.row + i] = s[c.row + i] - share_of_way(problem, c, std::abs(off)) * off;
    }
    return;
  }
  const double t = s[c.row + n - 1], a = s.segment(c.row, n - 1).norm();
  if (a <= t) return;
  const double share = a <= -t ? 0 : 0.5 * (1 + t / a);
  Eigen::VectorXd off = s.segment(c.row, n);
  off.head(n - 1) *= 1 - share;
  off[n - 1] -= share * a;
  z.segment(c.row, n) -= share_of_way(problem, c, off.norm()) * off;
}

/// Nearest point of the hard sets, and proximal point of the soft ones; disabled rows are free.
Eigen::VectorXd nearest(const ShootingProblem& problem, const Eigen::VectorXd& s) {
  Eigen::VectorXd z = s;
  for (const NodeConstraint& c : problem.constraints())
    if (!c.is_soft()) move_towards(problem, c, s, z);
  for (const NodeConstraint& c : problem.soft_constraints()) move_towards(problem, c, s, z);
  return z;
}

}  // namespace

Dense make_dense(const LinearQuadratic& lq, const ShootingProblem& problem, double low, double up) {
  Dense dense{.low = low, .up = up};
  lq.condense(dense.H, dense.g);
  const int n = static_cast<int>(dense.g.size());
  Evaluator evaluator(problem);
  dense.d = values_at(problem, evaluator, Eigen::VectorXd::Zero(n));
  dense.G.resize(dense.d.size(), n);
  for (int i = 0; i < n; ++i)
    dense.G.col(i) = values_at(problem, evaluator, Eigen::VectorXd::Unit(n, i)) - dense.d;
  return dense;
}

Eigen::VectorXd dense_optimum(const ShootingProblem& problem, const Dense& p) {
  const int n = static_cast<int>(p.g.size()), m = static_cast<int>(p.d.size());
  Eigen::MatrixXd A(m + n, n);
  A << p.G, Eigen::MatrixXd::Identity(n, n);
  const double rho = 1;
  const Eigen::LDLT<Eigen::MatrixXd> factor(p.H + rho * A.transpose() * A);
  Eigen::VectorXd U = Eigen::VectorXd::Zero(n), z = Eigen::VectorXd::Zero(m + n), y = z, s(m + n);
  Eigen::VectorXd offset = Eigen::VectorXd::Zero(m + n);
  offset.head(m) = p.d;
  for (int i = 0; i < 200000; ++i) {
    U = factor.solve(-p.g + rho * A.transpose() * (z - offset - y));
    const Eigen::VectorXd value = A * U + offset;
    s = value + y;
    const Eigen::VectorXd before = z;
    z.head(m) = nearest(problem, s.head(m));
    z.tail(n) = s.tail(n).cwiseMax(p.low).cwiseMin(p.up);
    y += value - z;
    if (i % 10 == 0 && (value - z).cwiseAbs().maxCoeff() < 1e-11 &&
        (z - before).cwiseAbs().maxCoeff() < 1e-11)
      break;
  }
  return U;
}

Eigen::VectorXd controls_of(const Trajectory& t) {
  int n = 0;
  for (int k = 0; k < t.knots(); ++k) n += t.nu(k);
  Eigen::VectorXd U(n);
  int at = 0;
  for (int k = 0; k < t.knots(); ++k) {
    U.segment(at, t.nu(k)) = t.u(k);
    at += t.nu(k);
  }
  return U;
}

std::vector<Added> cuts(const ShootingProblem& problem, const Trajectory& best) {
  const int N = problem.knots(), nu = problem.nu(0);
  double largest = 0;
  for (int k = 4; k <= N; ++k) largest = std::max(largest, std::abs(best.x(k)[0]));
  std::vector<double> end(2, 0.0);
  for (int i = 0; i < 2; ++i) end[i] = best.x(N)[i + 1] + 0.3;
  std::vector<double> shift(nu, 0.0);
  shift[nu - 1] = -2;
  return {{.name = "box",
           .residual = coordinate_residual(problem.manifold(), {0}),
           .reference = {0},
           .lower = {-0.8 * largest},
           .upper = {0.8 * largest},
           .first = 4,
           .last = N},
          {.name = "end",
           .residual = coordinate_residual(problem.manifold(), {1, 2}),
           .reference = end,
           .lower = {0, 0},
           .upper = {0, 0},
           .first = N,
           .last = N},
          {.name = "cone",
           .residual = control_residual(problem.ndx(), nu),
           .kind = ConstraintKind::second_order_cone,
           .reference = shift,
           .first = 0,
           .last = N / 2 - 1,
           .slope = 0.5}};
}

std::vector<Added> cuts(const LinearQuadratic& lq) { return cuts(*lq.problem, lq.dense_optimum()); }

}  // namespace conddp::testing
