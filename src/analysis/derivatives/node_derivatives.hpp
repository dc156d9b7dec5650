#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/moving_nodes.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// First derivatives of one node with respect to z = (δx, δu), nz numbers; only δx at the terminal
/// node.
struct NodeDerivatives {
  Eigen::VectorXd cost;        ///< nz
  Eigen::MatrixXd constraint;  ///< constraint rows of the node x nz
  /// Derivative of f ⊕ (−gap) ⊖ x_{k+1}, dynamics that preserve their gap: ndx x nz, empty at the
  /// terminal node.
  Eigen::MatrixXd step;
};

/// Derivatives of all nodes at a trajectory with these gaps (ndx x N), by dual numbers, column by
/// column (MovingNodes).
std::vector<NodeDerivatives> node_derivatives(const ShootingProblem& problem,
                                              const Trajectory& trajectory,
                                              const Eigen::MatrixXd& gap);

/// Derivatives of one node.
NodeDerivatives derivatives_of_node(const ShootingProblem& problem, int node, MovingNodes& moving);

}  // namespace conddp
