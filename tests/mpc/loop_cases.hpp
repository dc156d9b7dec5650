#pragma once

#include <memory>

#include "mpc/closed_loop.hpp"
#include "support/constrained_problems.hpp"

/// Closed-loop problems shared by the tests of this folder.
namespace conddp::testing {

inline std::shared_ptr<const ShootingProblem> shared(ShootingProblem problem) {
  return std::make_shared<const ShootingProblem>(std::move(problem));
}

/// A cart-pole near its upright state, with costs that return it there.
inline std::shared_ptr<const ShootingProblem> balanced_cartpole(std::vector<double> start = {
                                                                    0.3, M_PI - 0.3, 0, 0}) {
  return shared(tracking_problem(cartpole({}), Integrator::rk4, 40, 0.05, std::move(start),
                                 {{0, M_PI, 0, 0}, {1, 10, 0.1, 0.1}, {0.1}, {10, 100, 10, 10}},
                                 -10, 10));
}

/// Options of a loop whose windows end with the terminal costs.
inline MpcOptions with_terminal(const ShootingProblem& problem, MpcOptions options) {
  options.terminal = problem.terminal();
  return options;
}

inline SolverOptions tight() {
  SolverOptions options = tight_options();
  options.hessian = HessianChoice::gauss_newton;
  return options;
}

}  // namespace conddp::testing
