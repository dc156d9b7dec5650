#pragma once

#include <cmath>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "ocp/knot/knot_model.hpp"
#include "ocp/problem/problem.hpp"
#include "ocp/residuals/residuals.hpp"
#include "robot/model.hpp"
#include "support/expression_systems.hpp"
#include "support/random_robot.hpp"
#include "support/steps.hpp"
#include "systems/closed_forms/catalogue.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// A knot model with one random state, control, and parameter set.
struct KnotCase {
  std::string name;
  std::shared_ptr<const KnotModel> model;
  std::vector<double> x, u, parameters;
  double dt = 0.05;
};

/// A state at the given tangent scale from neutral, with large rotations.
inline std::vector<double> random_manifold_state(const StateManifold& manifold,
                                                 RandomNumbers& random, double size) {
  std::vector<double> x = manifold.neutral(), dx(manifold.ndx());
  for (double& d : dx) d = random.uniform(-size, size);
  manifold.integrate(x.data(), dx.data(), x.data());
  return x;
}

/// Derivative of next state and cost along one direction of z, by dual numbers through `evaluate`,
/// independent of all analytic derivatives.
struct DirectionalDerivative {
  Eigen::VectorXd next;
  double cost;
};
inline DirectionalDerivative directional_derivative(const KnotCase& c, int direction) {
  using D = Dual<Lane>;
  KnotBatch<D> batch(*c.model);
  const KnotModel& m = *c.model;
  for (int i = 0; i < m.nx(); ++i) batch.x[i] = D(c.x[i]);
  for (int i = 0; i < m.nu(); ++i) batch.u[i] = D(c.u[i]);
  for (int i = 0; i < m.parameter_count(); ++i) batch.parameters[i] = D(c.parameters[i]);
  batch.dt = D(c.dt);
  batch.cost_scale = D(c.dt);
  if (direction < m.ndx()) {
    for (D& t : batch.tangent) t = D(0.0);
    batch.tangent[direction].d = Lane(1.0);
    m.manifold().integrate(batch.x.data(), batch.tangent.data(), batch.x.data());
  } else {
    batch.u[direction - m.ndx()].d = Lane(1.0);
  }
  m.evaluate(batch.input(), batch.work);
  DirectionalDerivative result{Eigen::VectorXd::Zero(m.ndx()), batch.work.cost.d[0]};
  if (m.integrator() == Integrator::none) return result;
  AlignedVector<D> fixed(m.nx());
  for (int i = 0; i < m.nx(); ++i) fixed[i] = D(batch.work.next()[i].v, Lane(0.0));
  m.manifold().difference(fixed.data(), batch.work.next().data(), batch.tangent.data());
  for (int i = 0; i < m.ndx(); ++i) result.next[i] = batch.tangent[i].d[0];
  return result;
}

/// Random references: parameters for two poses suffice for any residual.
inline KnotCase make_case(std::string name, std::shared_ptr<KnotModel> model,
                          RandomNumbers& random) {
  KnotCase c;
  c.name = std::move(name);
  c.x = random_manifold_state(model->manifold(), random, 1.2);
  c.u = random.numbers(model->nu(), 2);
  if (model->integrator() == Integrator::impulse) c.dt = 0;
  c.parameters.resize(model->parameter_count());
  for (const CostTerm& term : model->costs()) {
    double* p = &c.parameters[term.parameters];
    const int n = term.residual->parameter_count();
    for (int i = 0; i < n; ++i) p[i] = random.uniform(-1, 1);
    if (n == model->nx()) {
      const auto reference = random_manifold_state(model->manifold(), random, 1.2);
      std::copy(reference.begin(), reference.end(), p);
    } else if (n == 4 || n == 7) {
      const auto q = random.rotation();
      p[n - 4] = q.x, p[n - 3] = q.y, p[n - 2] = q.z, p[n - 1] = q.w;
    }
    c.parameters[term.weight] = random.uniform(0.5, 2);
  }
  c.model = std::move(model);
  return c;
}

/// Every closed-form system and some robots.
inline std::vector<std::pair<std::string, std::shared_ptr<const System>>> test_systems() {
  RandomNumbers random(7);
  Eigen::MatrixXd A(3, 3), B(3, 2);
  Eigen::VectorXd offset(3);
  for (int i = 0; i < 3; ++i) {
    offset[i] = random.uniform(-1, 1);
    for (int j = 0; j < 3; ++j) A(i, j) = random.uniform(-1, 1);
    for (int j = 0; j < 2; ++j) B(i, j) = random.uniform(-1, 1);
  }
  std::vector<std::pair<std::string, std::shared_ptr<const System>>> systems = {
      {"double_integrator", double_integrator(2)},
      {"linear", linear_system(A, B, offset)},
      {"pendulum", pendulum({})},
      {"cartpole", cartpole({})},
      {"acrobot", acrobot({})},
      {"unicycle", unicycle()},
      {"car", car(2.0, 0.03)},
      {"planar_quadrotor", planar_quadrotor({})},
      {"quadrotor", quadrotor({})},
      {"lander", lander({})}};
  RandomRobotOptions arm{.joints = 5, .wrenches = 2};
  RandomRobotOptions flying{.joints = 4, .floating = true, .wrenches = 2};
  auto bolted = std::make_shared<RobotModel>(random_robot(3, arm));
  auto floating = std::make_shared<RobotModel>(random_robot(4, flying));
  for (Joint& joint : bolted->joints) {
    joint.damping = 0.3;
    joint.friction = 0.2;
  }
  systems.emplace_back("arm", std::make_shared<MultibodySystem>(bolted, Actuation::full(*bolted),
                                                                PassiveForces{true, true, 0.5}));
  systems.emplace_back("floating_arm",
                       std::make_shared<MultibodySystem>(floating, Actuation::full(*floating)));
  const std::vector<Contact> contacts{
      {.name = "point", .frame = static_cast<int>(floating->frames.size()) - 1, .kp = 3, .kd = 9}};
  systems.emplace_back("held_arm",
                       std::make_shared<MultibodySystem>(floating, Actuation::full(*floating),
                                                         PassiveForces{}, contacts));
  systems.emplace_back("impulse", std::make_shared<MultibodySystem>(floating, contacts, 0.5));
  // Rotations that are not first in their states, for first and second order.
  systems.emplace_back(
      "attitude",
      expression_system({.kind = SystemKind::first_order,
                         .states = {{"s", "m"}, {"q", "", ExpressionState::Kind::kUnitQuaternion}},
                         .controls = expression_columns({"wx", "wy", "wz"}),
                         .equations = {{"s", "rotate(q, [1, 2, 3]).z + wy"},
                                       {"q", "[wx, wy, wz] + 0.1*rotate_inverse(q, [s, 0, 1])"}}}));
  systems.emplace_back(
      "turning_mass",
      expression_system({.kind = SystemKind::second_order,
                         .states = {{"s", "m"}, {"q", "", ExpressionState::Kind::kUnitQuaternion}},
                         .velocities = expression_columns({"v", "w"}),
                         .controls = expression_columns({"f", "tx", "ty"}),
                         .equations = {{"v", "f - rotate(q, [1, 2, 3]).x"},
                                       {"w", "[tx, ty, 0.3*v] - cross(w, [0.5, 1, 2])"}}}));
  // Its floating base is neither first nor the only tree.
  const auto both = std::make_shared<RobotModel>(
      combine({random_robot(5, {.joints = 3, .wrenches = 1}),
               random_robot(6, {.joints = 2, .floating = true, .wrenches = 1})}));
  systems.emplace_back("arm_and_flying_arm",
                       std::make_shared<MultibodySystem>(both, Actuation::full(*both)));
  return systems;
}

inline std::vector<Integrator> integrators_of(const System& system) {
  switch (system.kind()) {
    case SystemKind::discrete:
      return {Integrator::discrete};
    case SystemKind::first_order:
      return {Integrator::explicit_euler, Integrator::rk2, Integrator::rk3, Integrator::rk4};
    case SystemKind::impulse:
      return {Integrator::impulse};
    case SystemKind::second_order:
      break;
  }
  return {Integrator::semi_implicit_euler, Integrator::explicit_euler, Integrator::rk2,
          Integrator::rk3, Integrator::rk4};
}

/// Consecutive knots of the case from its state, and a terminal node without costs.
inline ShootingProblem problem_of(const KnotCase& c, int count) {
  Phase phase{
      "knots", c.model, std::vector<double>(count, c.dt), std::vector<double>(count, c.dt), {}};
  for (int k = 0; k < count; ++k)
    phase.parameters.insert(phase.parameters.end(), c.parameters.begin(), c.parameters.end());
  auto end = std::make_shared<KnotModel>(c.model->step().without_dynamics());
  return {c.x, {phase}, Phase{"terminal", end, {0.0}, {1.0}, {}}};
}

}  // namespace conddp
