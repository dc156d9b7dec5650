#pragma once

#include <vector>

#include <Eigen/Dense>

#include "support/constrained_problems.hpp"

/// Convex problems with constraints, and their optimum by a method that shares nothing with the
/// solvers.
namespace conddp::testing {

/// A convex problem in all controls: ½ Uᵀ H U + gᵀ U with G U + d in the sets of its constraints
/// and U between bounds.
struct Dense {
  Eigen::MatrixXd H, G;
  Eigen::VectorXd g, d;
  double low, up;
};

/// The problem of `lq` with the constraints of `problem`, states eliminated.
Dense make_dense(const LinearQuadratic& lq, const ShootingProblem& problem, double low, double up);

/// The optimum by ADMM with an exact factor: nothing in common with the solvers.
Eigen::VectorXd dense_optimum(const ShootingProblem& problem, const Dense& p);

/// All controls, one after the other.
Eigen::VectorXd controls_of(const Trajectory& t);

/// Constraints that cut an optimum off, of every kind.
std::vector<Added> cuts(const ShootingProblem& problem, const Trajectory& best);

/// Those that cut off the optimum without any bound.
std::vector<Added> cuts(const LinearQuadratic& lq);

}  // namespace conddp::testing
