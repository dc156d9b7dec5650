#pragma once

#include <limits>
#include <memory>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/residuals/residuals.hpp"
#include "systems/closed_forms/catalogue.hpp"

/// Small problems shared by several solver tests.
namespace conddp::testing {

/// Running cost ½ (x − x_ref)ᵀ diag(q) (x − x_ref) + ½ uᵀ diag(r) u, times dt if `rates`; terminal
/// cost ½ (x − x_ref)ᵀ diag(qf) (x − x_ref).
struct TrackingCost {
  std::vector<double> goal, q, r, qf;
  bool rates = true;
};

/// Knots of one system with that cost and control limits.
Phase tracking_phase(std::shared_ptr<const System> system, Integrator integrator, int knots,
                     double dt, const TrackingCost& cost, double limit_low, double limit_up,
                     const std::string& name = "all");

/// The terminal node with the cost `qf`.
Phase terminal_phase(std::shared_ptr<const System> system, TrackingCost cost);

inline constexpr double kFree = std::numeric_limits<double>::infinity();

/// One phase and its terminal node.
ShootingProblem tracking_problem(const std::shared_ptr<const System>& system, Integrator integrator,
                                 int knots, double dt, std::vector<double> start,
                                 const TrackingCost& cost, double low = -kFree, double up = kFree);

/// Swing-ups and motions of catalogue systems, with controls within ± limit.
ShootingProblem pendulum_swing_up(double limit = kFree);
ShootingProblem cartpole_swing_up(double limit = kFree, Integrator integrator = Integrator::rk4);
ShootingProblem acrobot_swing_up(double limit = kFree);
ShootingProblem unicycle_parking(double limit = kFree);
ShootingProblem quadrotor_move(double limit_low = -kFree, double limit_up = kFree);

/// The hopper falls from 5 cm, an impulse stops its foot, and it comes to rest on its leg.
ShootingProblem landing(double limit = kFree);

/// Sets every control of a trajectory.
Trajectory constant_controls(const ShootingProblem& problem, double u);

/// Random states (flat spaces) and controls.
Trajectory random_guess(const ShootingProblem& problem, unsigned seed, double size = 1);

}  // namespace conddp::testing
