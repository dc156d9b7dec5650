#pragma once

#include <vector>

#include <Eigen/Dense>

#include "support/dense_horizon.hpp"
#include "support/plain_pendulum.hpp"
#include "support/small_qp.hpp"

namespace conddp::testing {

/// Newton's method on a pendulum with a terminal angle, a speed of at most `fastest` at node 3, and
/// limited controls. Enumerates active sets of the quadratic program of every iterate.
struct PlainSqp {
  PlainPendulum plain;
  double end = 0.8, fastest = 1;

  /// Rows: the speed at node 3, the angle at the end.
  ShootingProblem problem() const {
    const ShootingProblem free = plain.problem();
    return with_constraints(
        free, {affine_rows(Eigen::RowVector3d(0, 1, 0), free, 3, 3, -kFree, fastest),
               affine_rows(Eigen::RowVector2d(1, 0), free, plain.knots, plain.knots, end, end)});
  }

  struct Point {
    std::vector<Eigen::Vector2d> x;
    Eigen::VectorXd u;
    Eigen::Vector2d multipliers{0, 0};

    Trajectory trajectory(const ShootingProblem& problem) const {
      Trajectory t = problem.create_trajectory();
      for (std::size_t k = 0; k < x.size(); ++k) t.x(static_cast<int>(k)) = x[k];
      for (int k = 0; k < t.knots(); ++k) t.u(k)[0] = u[k];
      return t;
    }
    /// Largest difference of states and controls.
    double distance(const Trajectory& t) const {
      double largest = 0;
      for (int k = 0; k <= t.knots(); ++k)
        largest = std::max(largest, (t.x(k) - x[k]).lpNorm<Eigen::Infinity>());
      for (int k = 0; k < t.knots(); ++k) largest = std::max(largest, std::abs(t.u(k)[0] - u[k]));
      return largest;
    }
  };

  /// Multipliers of all constraint rows; most rows are disabled.
  Eigen::VectorXd rows(const Eigen::Vector2d& multipliers) const {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(plain.knots + 1);
    all[3] = multipliers[0];
    all[plain.knots] = multipliers[1];
    return all;
  }

  /// Motion of constant controls.
  Point simulated(double u) const {
    Point p{.x = {plain.start}, .u = Eigen::VectorXd::Constant(plain.knots, u)};
    for (int k = 0; k < plain.knots; ++k) p.x.push_back(plain.next<double>(p.x[k], u));
    return p;
  }

  /// Costates without gains, with the multipliers of the rows.
  std::vector<Eigen::Vector2d> costates(const Point& p) const {
    std::vector<Eigen::Vector2d> lambda(plain.knots + 1);
    lambda.back() = plain.end_gradient(p.x.back()) + Eigen::Vector2d(p.multipliers[1], 0);
    for (int k = plain.knots - 1; k >= 0; --k) {
      lambda[k] = plain.stage_gradient(p.x[k], p.u[k]).head<2>() +
                  plain.jacobian(p.x[k]).leftCols<2>().transpose() * lambda[k + 1];
      if (k == 3) lambda[k][1] += p.multipliers[0];
    }
    return lambda;
  }
  /// Horizon model with exact or cost Hessians, and cost gradients.
  DenseHorizon model(const Point& p, const ShootingProblem& problem, bool exact) const {
    const auto lambda = costates(p);
    Linearization l(problem);
    for (int k = 0; k <= plain.knots; ++k) {
      KnotLinearization& knot = l.knots[k];
      if (k == plain.knots) {
        knot.gradient = plain.end_gradient(p.x[k]);
        knot.hessian.change() = plain.qf.asDiagonal();
        break;
      }
      knot.gradient = plain.stage_gradient(p.x[k], p.u[k]);
      Eigen::MatrixXd& H = knot.hessian.change();
      H = plain.stage_hessian();
      if (exact) H(0, 0) += plain.curvature(p.x[k], lambda[k + 1]);
      knot.F = plain.jacobian(p.x[k]).row(1);
      l.gap.col(k) = plain.next<double>(p.x[k], p.u[k]) - p.x[k + 1];
    }
    return {l, true};
  }
  /// The next iterate.
  Point step(const Point& p, const ShootingProblem& problem, bool exact = true) const {
    const DenseHorizon dense = model(p, problem, exact);
    const int N = plain.knots;
    SmallQp qp{.H = dense.S.transpose() * dense.H * dense.S,
               .g = dense.S.transpose() * (dense.H * dense.s + dense.g),
               .A = Eigen::MatrixXd(N + 2, N),
               .lower = Eigen::VectorXd(N + 2),
               .upper = Eigen::VectorXd(N + 2)};
    const int speed = dense.offset[3] + 1, angle = dense.offset[N];
    qp.A << dense.S.row(speed), dense.S.row(angle), Eigen::MatrixXd::Identity(N, N);
    qp.lower << -kFree, end - p.x[N][0] - dense.s[angle], (-plain.limit - p.u.array()).matrix();
    qp.upper << fastest - p.x[3][1] - dense.s[speed], qp.lower[1],
        (plain.limit - p.u.array()).matrix();
    const SmallQpOptimum optimum = enumerate_active_sets(qp);
    Point next{.x = p.x, .u = p.u + optimum.x, .multipliers = optimum.multipliers.head<2>()};
    const Eigen::VectorXd z = dense.S * optimum.x + dense.s;
    for (int k = 0; k <= N; ++k) next.x[k] += z.segment<2>(dense.offset[k]);
    return next;
  }
  /// The solution near a point.
  Point solution(Point p, const ShootingProblem& problem) const {
    for (int i = 0; i < 20; ++i) p = step(p, problem);
    return p;
  }
};

}  // namespace conddp::testing
