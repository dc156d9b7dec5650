#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/node_derivatives.hpp"
#include "ocp/evaluation/linearization.hpp"

namespace conddp {

/// The model of every node at a trajectory.
struct NodeModels {
  std::vector<NodeDerivatives> derivatives;
  std::vector<Eigen::MatrixXd> hessians;  ///< Gauss-Newton, nz x nz, without terms of multipliers
  /// Nodes whose derivatives are those of dual numbers.
  int by_dual_numbers = 0;
};

/// The models at a trajectory with these gaps (ndx x N). Derivatives are those of dual numbers
/// (node_derivatives), to rounding: a node keeps its analytic ones where these say what dual
/// numbers say along two random directions, one of the state and one of the control. No wrong entry
/// that rounding does not hide has a product with both that is right.
NodeModels node_models(const ShootingProblem& problem, const Trajectory& trajectory,
                       const Eigen::MatrixXd& gap);

/// The same from the analytic derivatives of all nodes there, without terms of multipliers.
NodeModels confirmed_models(const ShootingProblem& problem, const Trajectory& trajectory,
                            const Eigen::MatrixXd& gap, Linearization analytic);

}  // namespace conddp
