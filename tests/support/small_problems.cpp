#include "support/small_problems.hpp"

#include <cmath>
#include <filesystem>
#include <random>

#include "robot/urdf/urdf.hpp"
#include "spatial/so3.hpp"
#include "support/source_tree.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp::testing {

Phase tracking_phase(std::shared_ptr<const System> system, Integrator integrator, int knots,
                     double dt, const TrackingCost& cost, double limit_low, double limit_up,
                     const std::string& name) {
  auto model = std::make_shared<KnotModel>(system, integrator);
  std::vector<double> one(cost.goal);
  one.push_back(1);
  model->add_cost("state", state_residual(model->manifold()), {.weights = cost.q});
  if (model->nu() > 0) {
    model->add_cost("control", control_residual(model->ndx(), model->nu()), {.weights = cost.r});
    one.insert(one.end(), model->nu(), 0.0);
    one.push_back(1);
    model->set_control_bounds(std::vector<double>(model->nu(), limit_low),
                              std::vector<double>(model->nu(), limit_up));
  }
  Phase phase{.name = name, .model = model};
  for (int k = 0; k < knots; ++k) {
    phase.dt.push_back(dt);
    phase.cost_scale.push_back(cost.rates && integrator != Integrator::none ? dt : 1);
    phase.parameters.insert(phase.parameters.end(), one.begin(), one.end());
  }
  return phase;
}

Phase terminal_phase(std::shared_ptr<const System> system, TrackingCost cost) {
  cost.q = cost.qf;
  return tracking_phase(std::move(system), Integrator::none, 1, 0, cost, 0, 0, "end");
}

ShootingProblem tracking_problem(const std::shared_ptr<const System>& system, Integrator integrator,
                                 int knots, double dt, std::vector<double> start,
                                 const TrackingCost& cost, double low, double up) {
  return ShootingProblem(std::move(start),
                         {tracking_phase(system, integrator, knots, dt, cost, low, up)},
                         terminal_phase(system, cost));
}

ShootingProblem pendulum_swing_up(double limit) {
  return tracking_problem(pendulum({}), Integrator::rk4, 50, 0.06, {0, 0},
                          {{M_PI, 0}, {1e-3, 1e-3}, {1e-3}, {10, 10}}, -limit, limit);
}

ShootingProblem cartpole_swing_up(double limit, Integrator integrator) {
  return tracking_problem(cartpole({}), integrator, 100, 0.05, {0, 0, 0, 0},
                          {{0, M_PI, 0, 0}, {0.01, 0.01, 0.01, 0.01}, {0.1}, {100, 100, 100, 100}},
                          -limit, limit);
}

ShootingProblem acrobot_swing_up(double limit) {
  return tracking_problem(acrobot({}), Integrator::rk4, 100, 0.05, {-M_PI / 2, 0, 0, 0},
                          {{M_PI / 2, 0, 0, 0}, {1, 1, 1, 1}, {0.01}, {100, 100, 100, 100}}, -limit,
                          limit);
}

ShootingProblem unicycle_parking(double limit) {
  return tracking_problem(unicycle(), Integrator::rk4, 100, 0.05, {0, 0, 0},
                          {{3, 3, 0}, {1, 1, 1}, {0.5, 0.5}, {10, 10, 10}}, -limit, limit);
}

ShootingProblem quadrotor_move(double limit_low, double limit_up) {
  const std::vector<double> running = {1e-2, 1e-2, 1e-2, 1e-2, 1e-2, 1e-2,
                                       1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3};
  const std::vector<double> final(12, 10.0);
  return tracking_problem(quadrotor({}), Integrator::semi_implicit_euler, 50, 0.04,
                          {0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0},
                          {{2, 1, 2, 0, 0, std::sin(0.6), std::cos(0.6), 0, 0, 0, 0, 0, 0},
                           running,
                           {1e-2, 1e-2, 1e-2, 1e-2},
                           final},
                          limit_low, limit_up);
}

ShootingProblem landing(double limit) {
  const UrdfResult urdf =
      load_urdf(source_tree() / "problems/robots/hopper.urdf",
                {.base = UrdfOptions::Base::planar,
                 .placement = SE3<double>{rotation_matrix(exp_so3(Vector3<double>{M_PI / 2, 0, 0})),
                                          Vector3<double>::zero()}});
  const auto robot = std::make_shared<const RobotModel>(urdf.model.value());
  const std::vector<Contact> foot = {
      {.name = "foot", .frame = *robot->find_frame("foot"), .kd = 50}};
  const auto in_the_air =
      std::make_shared<MultibodySystem>(robot, Actuation::joints(*robot, {"hip", "knee"}));
  const auto touch_down = std::make_shared<MultibodySystem>(robot, foot, 0.0);
  const double bend = 0.5;
  const TrackingCost cost{.goal = {0, 0.6 * std::cos(bend), 0, bend, -2 * bend, 0, 0, 0, 0, 0},
                          .q = {1, 1, 1, 1, 1, 0.1, 0.1, 0.1, 0.1, 0.1},
                          .r = {1e-3, 1e-3},
                          .qf = {10, 10, 10, 10, 10, 1, 1, 1, 1, 1}};
  std::vector<double> start = cost.goal;
  start[1] += 0.05;
  const Integrator euler = Integrator::semi_implicit_euler;
  return ShootingProblem(
      std::move(start),
      {tracking_phase(in_the_air, euler, 10, 0.01, cost, -limit, limit, "flight"),
       tracking_phase(touch_down, Integrator::impulse, 1, 0, cost, 0, 0, "touch_down"),
       tracking_phase(in_the_air->with_contacts(foot), euler, 30, 0.01, cost, -limit, limit,
                      "stance")},
      terminal_phase(in_the_air, cost));
}

Trajectory constant_controls(const ShootingProblem& problem, double u) {
  Trajectory guess = problem.create_trajectory();
  for (int k = 0; k < problem.knots(); ++k) guess.u(k).setConstant(u);
  return guess;
}

Trajectory random_guess(const ShootingProblem& problem, unsigned seed, double size) {
  std::mt19937 engine(seed);
  std::normal_distribution<double> normal(0, size);
  Trajectory guess = problem.create_trajectory();
  for (int k = 0; k <= problem.knots(); ++k) {
    for (double& x : guess.x(k)) x = normal(engine);
    if (k == problem.knots()) break;
    for (double& u : guess.u(k)) u = normal(engine);
  }
  return guess;
}

}  // namespace conddp::testing
