#pragma once

#include <vector>

#include <Eigen/Dense>

#include "support/constrained_problems.hpp"

/// Convex constrained problems and their optimum by a method independent of the solvers.
namespace conddp::testing {

/// A convex problem in all controls: ½ Uᵀ H U + gᵀ U with G U + d in the constraint sets and U
/// between bounds.
struct Dense {
  Eigen::MatrixXd H, G;
  Eigen::VectorXd g, d;
  double low, up;
};

/// The problem of `lq` with the constraints of `problem`, with states eliminated.
Dense make_dense(const LinearQuadratic& lq, const ShootingProblem& problem, double low, double up);

/// Optimum by ADMM with an exact factorization, independent of the solvers.
Eigen::VectorXd dense_optimum(const ShootingProblem& problem, const Dense& p);

/// All controls stacked.
Eigen::VectorXd controls_of(const Trajectory& t);

/// Constraints of every kind that exclude an optimum.
std::vector<Added> cuts(const ShootingProblem& problem, const Trajectory& best);

/// Constraints that exclude the optimum without bounds.
std::vector<Added> cuts(const LinearQuadratic& lq);

}  // namespace conddp::testing
