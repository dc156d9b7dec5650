#pragma once

#include <array>
#include <cmath>
#include <complex>
#include <vector>

#include <Eigen/Dense>

#include "support/small_problems.hpp"

namespace conddp::testing {

/// A pendulum with semi-implicit Euler and quadratic costs in plain arithmetic with hand-derived
/// derivatives, and the equivalent ShootingProblem. Supports complex numbers.
struct PlainPendulum {
  int knots = 5;
  double dt = 0.1;
  Eigen::Vector2d start{0.4, -0.3}, goal{1.2, 0.1};
  Eigen::Vector2d q{1.5, 0.2}, qf{8, 2};  ///< of rates, and of the end
  double r = 0.3;                         ///< of a rate
  double limit = kFree;                   ///< of |u|
  double mass = 1, length = 0.5, inertia = 0.25, damping = 0.1, gravity = 9.81;

  template <class S>
  using State = Eigen::Matrix<S, 2, 1>;

  template <class S>
  State<S> next(const State<S>& x, S u) const {
    using std::sin;
    const S omega =
        x[1] + dt * (u - mass * gravity * length * sin(x[0]) - damping * x[1]) / inertia;
    return {x[0] + dt * omega, omega};
  }
  /// By (θ, ω, u).
  Eigen::Matrix<double, 2, 3> jacobian(const Eigen::Vector2d& x) const {
    Eigen::Matrix<double, 2, 3> J;
    J.row(1) << -dt * mass * gravity * length * std::cos(x[0]) / inertia,
        1 - dt * damping / inertia, dt / inertia;
    J.row(0) = dt * J.row(1);
    J(0, 0) += 1;
    return J;
  }
  /// ∂²(λᵀ next)/∂θ²; all other second derivatives vanish.
  double curvature(const Eigen::Vector2d& x, const Eigen::Vector2d& lambda) const {
    return (dt * lambda[0] + lambda[1]) * dt * mass * gravity * length * std::sin(x[0]) / inertia;
  }

  template <class S>
  S stage_cost(const State<S>& x, S u) const {
    const State<S> e = x - goal.cast<S>();
    return 0.5 * dt * (q[0] * e[0] * e[0] + q[1] * e[1] * e[1] + r * u * u);
  }
  Eigen::Vector3d stage_gradient(const Eigen::Vector2d& x, double u) const {
    return dt * Eigen::Vector3d(q[0] * (x[0] - goal[0]), q[1] * (x[1] - goal[1]), r * u);
  }
  Eigen::Matrix3d stage_hessian() const {
    return dt * Eigen::Vector3d(q[0], q[1], r).asDiagonal().toDenseMatrix();
  }
  template <class S>
  S end_cost(const State<S>& x) const {
    const State<S> e = x - goal.cast<S>();
    return 0.5 * (qf[0] * e[0] * e[0] + qf[1] * e[1] * e[1]);
  }
  Eigen::Vector2d end_gradient(const Eigen::Vector2d& x) const { return qf.cwiseProduct(x - goal); }

  /// Cost from x at knot `first`, where controls are v + K (x − x̄) and each step ends at next +
  /// offset.
  template <class S>
  S cost_to_go(int first, State<S> x, const std::vector<S>& v,
               const std::vector<Eigen::RowVector2d>& K,
               const std::vector<Eigen::Vector2d>& nominal,
               const std::vector<State<S>>& offset) const {
    S sum(0);
    for (int k = first; k < knots; ++k) {
      const State<S> away = x - nominal[k].cast<S>();
      const S u = v[k] + K[k][0] * away[0] + K[k][1] * away[1];
      sum += stage_cost<S>(x, u);
      x = next<S>(x, u) + offset[k];
    }
    return sum + end_cost<S>(x);
  }

  ShootingProblem problem() const {
    const auto plain = [](const Eigen::Vector2d& v) { return std::vector<double>{v[0], v[1]}; };
    return tracking_problem(pendulum({mass, length, inertia, damping, gravity}),
                            Integrator::semi_implicit_euler, knots, dt, plain(start),
                            {plain(goal), plain(q), {r}, plain(qf)}, -limit, limit);
  }
};

}  // namespace conddp::testing
