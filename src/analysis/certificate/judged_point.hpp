#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/node_derivatives.hpp"
#include "ocp/problem/problem.hpp"
#include "ocp/problem/trajectory.hpp"

namespace conddp {

/// The point to be judged.
struct JudgedPoint {
  const ShootingProblem& problem;
  const Trajectory& trajectory;
  const Eigen::MatrixXd& gap;                        ///< ndx x N
  const std::vector<NodeDerivatives>& derivatives;   ///< at the trajectory
  const std::vector<Eigen::MatrixXd>& gauss_newton;  ///< Hessians of the costs, nz x nz
  const Eigen::VectorXd& values;                     ///< values of all constraint rows
  const Eigen::VectorXd& multipliers;                ///< multipliers of all constraint rows
  /// Co-states (ndx x (N + 1)) and ∂L/∂u of an adjoint pass with these multipliers.
  const Eigen::MatrixXd& costates;
  const std::vector<Eigen::VectorXd>& control_gradient;
  double cost_size = 0;   ///< sum of the absolute values of all costs
  double negligible = 0;  ///< cost change that counts as nothing
};

}  // namespace conddp
