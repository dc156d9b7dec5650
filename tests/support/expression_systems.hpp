#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "systems/closed_forms/catalogue.hpp"
#include "systems/expressions/system.hpp"

namespace conddp {

/// A system from expressions; throws on errors.
inline std::shared_ptr<const System> expression_system(const ExpressionSystemText& text) {
  ParsedExpressionSystem parsed = make_expression_system(text);
  if (!parsed.errors.empty()) throw std::invalid_argument(parsed.errors[0].message.message);
  return parsed.system;
}

/// A catalogue system and the same system as expressions.
struct SystemInWords {
  std::string name;
  std::shared_ptr<const System> compiled;
  ExpressionSystemText text;
};

inline std::vector<ExpressionState> expression_numbers(const std::vector<std::string>& names) {
  std::vector<ExpressionState> states;
  for (const std::string& name : names) states.push_back({name});
  return states;
}
inline std::vector<Column> expression_columns(const std::vector<std::string>& names) {
  std::vector<Column> columns;
  for (const std::string& name : names) columns.push_back({name, "1"});
  return columns;
}

/// Every closed-form system.
inline std::vector<SystemInWords> systems_in_words() {
  std::vector<SystemInWords> all;
  all.push_back({"double_integrator",
                 double_integrator(2),
                 {.kind = SystemKind::second_order,
                  .states = expression_numbers({"x", "y"}),
                  .velocities = expression_columns({"vx", "vy"}),
                  .controls = expression_columns({"ax", "ay"}),
                  .equations = {{"vx", "ax"}, {"vy", "ay"}}}});
  const Eigen::MatrixXd A = Eigen::MatrixXd{{0.9, -0.2, 0.1}, {0.3, 1.1, 0}, {0, -0.4, 0.7}};
  const Eigen::MatrixXd B = Eigen::MatrixXd{{0.1, 0}, {0, -0.3}, {0.5, 0.2}};
  const Eigen::VectorXd c = Eigen::VectorXd{{0.01, -0.02, 0}};
  all.push_back({"linear",
                 linear_system(A, B, c),
                 {.kind = SystemKind::discrete,
                  .states = expression_numbers({"a", "b", "c"}),
                  .controls = expression_columns({"u", "w"}),
                  .equations = {{"a", "0.9*a - 0.2*b + 0.1*c + 0.1*u + 0.01"},
                                {"b", "0.3*a + 1.1*b - 0.3*w - 0.02"},
                                {"c", "-0.4*b + 0.7*c + 0.5*u + 0.2*w"}}}});
  const PendulumParameters p;
  all.push_back(
      {"pendulum",
       pendulum(p),
       {.kind = SystemKind::second_order,
        .states = {{"theta", "rad"}},
        .velocities = {{"omega", "rad/s"}},
        .controls = {{"torque", "Nm"}},
        .parameters =
            {{"m", p.mass}, {"l", p.length}, {"I", p.inertia}, {"d", p.damping}, {"g", p.gravity}},
        .equations = {{"omega", "(torque - m*g*l*sin(theta) - d*omega)/I"}}}});
  const CartpoleParameters cp;
  all.push_back(
      {"cartpole",
       cartpole(cp),
       {.kind = SystemKind::second_order,
        .states = expression_numbers({"x", "theta"}),
        .velocities = expression_columns({"vx", "omega"}),
        .controls = expression_columns({"force"}),
        .parameters =
            {{"M", cp.cart_mass}, {"m", cp.pole_mass}, {"l", cp.length}, {"g", cp.gravity}},
        .definitions = {{"s", "sin(theta)"},
                        {"c", "cos(theta)"},
                        {"d", "M + m*s^2"},
                        {"push", "force + m*l*s*omega^2"}},
        .equations = {{"omega", "-(push*c + (M + m)*g*s)/(l*d)"}, {"vx", "(push + m*g*s*c)/d"}}}});
  const AcrobotParameters a;
  all.push_back(
      {"acrobot",
       acrobot(a),
       {.kind = SystemKind::second_order,
        .states = expression_numbers({"theta1", "theta2"}),
        .velocities = expression_columns({"omega1", "omega2"}),
        .controls = expression_columns({"elbow"}),
        .parameters = {{"l1", a.length1},
                       {"l2", a.length2},
                       {"m1", a.mass1},
                       {"m2", a.mass2},
                       {"I1", a.inertia1},
                       {"I2", a.inertia2},
                       {"friction", a.friction},
                       {"g", a.gravity}},
        .definitions = {{"k", "m2*l1*l2"},
                        {"m22", "m2*l2^2 + I2"},
                        {"m12", "m22 + k*cos(theta2)"},
                        {"m11", "(m1 + m2)*l1^2 + m2*l2^2 + I1 + I2 + 2*k*cos(theta2)"},
                        {"h", "k*sin(theta2)"},
                        {"c12", "m2*l2*g*cos(theta1 + theta2)"},
                        {"b1",
                         "-h*omega2^2 - 2*h*omega1*omega2 + (m1 + m2)*l1*g*cos(theta1) + c12"},
                        {"b2", "h*omega1^2 + c12"},
                        {"tau1", "-b1 - friction*omega1"},
                        {"tau2", "elbow - b2 - friction*omega2"},
                        {"det", "m11*m22 - m12^2"}},
        .equations = {{"omega1", "(m22*tau1 - m12*tau2)/det"},
                      {"omega2", "(m11*tau2 - m12*tau1)/det"}}}});
  all.push_back(
      {"unicycle",
       unicycle(),
       {.kind = SystemKind::first_order,
        .states = expression_numbers({"x", "y", "theta"}),
        .controls = expression_columns({"v", "omega"}),
        .equations = {{"x", "v*cos(theta)"}, {"y", "v*sin(theta)"}, {"theta", "omega"}}}});
  all.push_back({"car",
                 car(2.0, 0.03),
                 {.kind = SystemKind::discrete,
                  .states = expression_numbers({"x", "y", "theta", "v"}),
                  .controls = expression_columns({"w", "a"}),
                  .parameters = {{"d", 2.0}, {"h", 0.03}},
                  .definitions = {{"front", "h*v"},
                                  {"lateral", "front*sin(w)"},
                                  {"back", "d + front*cos(w) - sqrt(d^2 - lateral^2)"}},
                  .equations = {{"x", "x + back*cos(theta)"},
                                {"y", "y + back*sin(theta)"},
                                {"theta", "theta + asin(lateral/d)"},
                                {"v", "v + a*h"}}}});
  const PlanarQuadrotorParameters pq;
  all.push_back(
      {"planar_quadrotor",
       planar_quadrotor(pq),
       {.kind = SystemKind::second_order,
        .states = expression_numbers({"x", "z", "theta"}),
        .velocities = expression_columns({"vx", "vz", "omega"}),
        .controls = expression_columns({"right", "left"}),
        .parameters = {{"m", pq.mass}, {"I", pq.inertia}, {"r", pq.arm}, {"g", pq.gravity}},
        .definitions = {{"thrust", "(right + left)/m"}},
        .equations = {{"vx", "-thrust*sin(theta)"},
                      {"vz", "thrust*cos(theta) - g"},
                      {"omega", "(right - left)*(r/I)"}}}});
  const QuadrotorParameters q;
  all.push_back(
      {"quadrotor",
       quadrotor(q),
       {.kind = SystemKind::second_order,
        .states = {{"body", "", ExpressionState::Kind::kPose}},
        .velocities = {{"twist", "1"}},
        .controls = expression_columns({"front", "left", "back", "right"}),
        .parameters = {{"m", q.mass},
                       {"jx", q.jx},
                       {"jy", q.jy},
                       {"jz", q.jz},
                       {"r", q.arm},
                       {"k", q.torque_ratio},
                       {"g", q.gravity}},
        .definitions = {{"w", "twist.angular"},
                        {"thrust", "[0, 0, (front + left + back + right)/m]"},
                        {"linear",
                         "rotate_inverse(body.rotation, [0, 0, -g]) - cross(w, twist.linear) + "
                         "thrust"},
                        {"roll", "(r*(left - right) - (jz - jy)*w.y*w.z)/jx"},
                        {"pitch", "(r*(back - front) - (jx - jz)*w.z*w.x)/jy"},
                        {"yaw", "(k*(front - left + back - right) - (jy - jx)*w.x*w.y)/jz"}},
        .equations = {{"twist", "[linear, roll, pitch, yaw]"}}}});
  const LanderParameters lp;
  all.push_back({"lander",
                 lander(lp),
                 {.kind = SystemKind::first_order,
                  .states = expression_numbers({"x", "y", "z", "vx", "vy", "vz", "burnt"}),
                  .controls = expression_columns({"tx", "ty", "tz"}),
                  .parameters = {{"m", lp.mass},
                                 {"rate", lp.fuel_rate},
                                 {"g", lp.gravity},
                                 {"rounding", kThrustRounding}},
                  .definitions = {{"a", "[tx, ty, tz]/(m - burnt)"}},
                  .equations = {{"x", "vx"},
                                {"y", "vy"},
                                {"z", "vz"},
                                {"vx", "a.x"},
                                {"vy", "a.y"},
                                {"vz", "a.z - g"},
                                {"burnt", "rate*smooth_norm([tx, ty, tz], rounding)"}}}});
  return all;
}

}  // namespace conddp
