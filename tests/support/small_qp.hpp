#pragma once

#include <Eigen/Dense>

namespace conddp::testing {

/// A small convex quadratic program: ½ xᵀ H x + gᵀ x with lower ≤ A x ≤ upper.
struct SmallQp {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  Eigen::MatrixXd A;
  Eigen::VectorXd lower, upper;

  double value(const Eigen::VectorXd& x) const { return 0.5 * x.dot(H * x) + g.dot(x); }
};

/// Optimum of a SmallQp and the multipliers of its rows, positive at upper bounds: H x + g + Aᵀ ν =
/// 0.
struct SmallQpOptimum {
  Eigen::VectorXd x, multipliers;
};

/// Tries all active sets, 3 to the number of rows, until the optimality conditions hold. Fails the
/// test if they never do.
SmallQpOptimum enumerate_active_sets(const SmallQp& qp);

}  // namespace conddp::testing
