// Confirms in long double that rounding of the cost hides the remaining decrease. Independent code
// integrates the controls of the answer, and a Newton step continues to the optimum.
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Cholesky>

#include "support/transcribed_problem.hpp"

namespace conddp::rounding_floor {
namespace {

using Extended = long double;
using Vector = Eigen::Matrix<Extended, Eigen::Dynamic, 1>;
using Matrix = Eigen::Matrix<Extended, Eigen::Dynamic, Eigen::Dynamic>;

/// A number and its directional derivative.
struct Number {
  Extended v, d;
  Number(Extended value = 0, Extended derivative = 0)  // NOLINT(google-explicit-constructor)
      : v(value), d(derivative) {}

  friend Number operator+(const Number& a, const Number& b) { return {a.v + b.v, a.d + b.d}; }
  friend Number operator-(const Number& a, const Number& b) { return {a.v - b.v, a.d - b.d}; }
  friend Number operator*(const Number& a, const Number& b) {
    return {a.v * b.v, a.d * b.v + a.v * b.d};
  }
  friend Number operator/(const Number& a, const Number& b) {
    return {a.v / b.v, (a.d - a.v / b.v * b.d) / b.v};
  }
};

std::pair<Number, Number> sine_and_cosine(const Number& a) {
  const Extended s = std::sin(a.v), c = std::cos(a.v);
  return {{s, c * a.d}, {c, -s * a.d}};
}

/// Problems as in their files; constants are the doubles of the files.
struct PendulumSwingup {
  static constexpr int nx = 2, knots = 50;
  static constexpr double dt = 3.0 / 50, effort = 1e-3, state = 1e-3, upright = 100, bound = 3;
  static constexpr double target[nx] = {3.141592653589793, 0};

  static void rate(const Number* x, const Number& u, Number* f) {
    const Number mass = 1, gravity = 9.81, length = 0.5, inertia = 0.25, damping = 0.1;
    f[0] = x[1];
    f[1] = (u - mass * gravity * length * sine_and_cosine(x[0]).first - damping * x[1]) / inertia;
  }
};

struct CartpoleSwingup {
  static constexpr int nx = 4, knots = 100;
  static constexpr double dt = 0.03, effort = 0.02, state = 0.1, upright = 200, bound = 10;
  static constexpr double target[nx] = {0, 3.141592653589793, 0, 0};

  static void rate(const Number* x, const Number& u, Number* f) {
    const Number cart = 1, pole = 0.2, length = 0.5, gravity = 9.81;
    const auto [s, c] = sine_and_cosine(x[1]);
    const Number inertia = cart + pole * s * s, push = u + pole * length * s * x[3] * x[3];
    f[0] = x[2];
    f[1] = x[3];
    f[2] = (push + pole * gravity * s * c) / inertia;
    f[3] = (Number(0) - push * c - (cart + pole) * gravity * s) / (inertia * length);
  }
};

template <class Problem>
Number half_distance(const Number* x) {
  Number sum = 0;
  for (int i = 0; i < Problem::nx; ++i) {
    const Number r = x[i] - Problem::target[i];
    sum = sum + r * r;
  }
  return sum / 2;
}

/// Cost of controls from rest at the origin by the classic Runge-Kutta rule, and its derivative
/// with respect to the control of one knot.
template <class Problem>
Number cost(const Vector& controls, int along = -1) {
  constexpr int nx = Problem::nx;
  const Number dt = Problem::dt, ahead[] = {0, dt / 2, dt / 2, dt}, sixth = dt / 6;
  Number x[nx] = {}, total = 0;
  for (int knot = 0; knot < controls.size(); ++knot) {
    const Number u(controls[knot], knot == along);
    total = total + dt * (Number(Problem::effort) * u * u / 2 +
                          Number(Problem::state) * half_distance<Problem>(x));
    Number stage[nx], k[4][nx];
    for (int s = 0; s < 4; ++s) {
      for (int i = 0; i < nx; ++i) stage[i] = s == 0 ? x[i] : x[i] + ahead[s] * k[s - 1][i];
      Problem::rate(stage, u, k[s]);
    }
    for (int i = 0; i < nx; ++i)
      x[i] = x[i] + sixth * (k[0][i] + Number(2) * (k[1][i] + k[2][i]) + k[3][i]);
  }
  return total + Number(Problem::upright) * half_distance<Problem>(x);
}

/// Derivatives with respect to the controls of these knots.
template <class Problem>
Vector gradient(const Vector& controls, const std::vector<int>& knots) {
  Vector g(knots.size());
  for (std::size_t i = 0; i < knots.size(); ++i) g[i] = cost<Problem>(controls, knots[i]).d;
  return g;
}

template <class Problem>
Matrix hessian(const Vector& controls, const std::vector<int>& knots) {
  constexpr Extended kStep = 1e-7L;
  Matrix H(knots.size(), knots.size());
  for (std::size_t j = 0; j < knots.size(); ++j) {
    Vector ahead = controls, behind = controls;
    ahead[knots[j]] += kStep;
    behind[knots[j]] -= kStep;
    H.col(j) = (gradient<Problem>(ahead, knots) - gradient<Problem>(behind, knots)) / (2 * kStep);
  }
  return (H + H.transpose()) / 2;
}

template <class Problem>
void expect_that_doubles_cannot_show_what_is_left(const std::string& file) {
  const testing::ReadyProblem ready(file, {"solver.tolerances={stationarity: 1.0e-18}"});
  const SolveResult result = solve(*ready.built.problem, ready.spec.solver.name.value,
                                   ready.spec.solver.options, ready.built.guess);
  ASSERT_EQ(result.status, SolveStatus::line_search_failed) << result.message;
  ASSERT_EQ(result.failed_quantity, kRoundedCost) << result.message;
  double rounding = 0;
  ASSERT_EQ(std::sscanf(result.message.c_str(), "the cost's rounding (%lf)", &rounding), 1)
      << result.message;

  Vector u(Problem::knots);
  std::vector<int> free;
  for (int k = 0; k < Problem::knots; ++k) {
    u[k] = result.trajectory.u(k)[0];
    if (std::abs(u[k]) < Problem::bound) free.push_back(k);
  }
  for (int k = 0; k < Problem::knots; ++k) {
    if (std::abs(u[k]) == Problem::bound) {
      EXPECT_LT(cost<Problem>(u, k).d * u[k], 0) << "the control of knot " << k << " is to leave";
    }
  }
  EXPECT_LE(std::abs(cost<Problem>(u).v - result.cost), rounding) << "not the same problem";

  const Vector g = gradient<Problem>(u, free);
  const Eigen::LLT<Matrix> factor(hessian<Problem>(u, free));
  ASSERT_EQ(factor.info(), Eigen::Success) << "not a minimum";
  const Vector step = factor.solve(-g);
  const Extended left = -g.dot(step) / 2;
  Vector optimum = u;
  optimum(free) += step;
  EXPECT_LT(gradient<Problem>(optimum, free).template lpNorm<Eigen::Infinity>(),
            g.template lpNorm<Eigen::Infinity>() / 10)
      << "the Newton step does not lead to the optimum";

  // Less than the rounding of one double of the cost's size.
  const double last_digit = std::numeric_limits<double>::epsilon() / 2 * result.cost;
  EXPECT_LT(left, last_digit);
  EXPECT_LT(last_digit, rounding);
}

TEST(RoundingFloor, PendulumIsConfirmedInLongDouble) {
  expect_that_doubles_cannot_show_what_is_left<PendulumSwingup>("pendulum_swingup");
}

TEST(RoundingFloor, CartpoleIsConfirmedInLongDouble) {
  expect_that_doubles_cannot_show_what_is_left<CartpoleSwingup>("cartpole_swingup_closed_form");
}

}  // namespace
}  // namespace conddp::rounding_floor
