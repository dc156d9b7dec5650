#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/moving_nodes.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// First derivatives of one node by z = (δx, δu), nz numbers; of the terminal node by δx alone.
struct NodeDerivatives {
  Eigen::VectorXd cost;        ///< nz
  Eigen::MatrixXd constraint;  ///< of the node's constraint rows x nz
  /// Of f ⊕ (−gap) ⊖ x_{k+1}, dynamics that keep the gap they have: ndx x nz, none at the terminal
  /// node.
  Eigen::MatrixXd step;
};

/// The derivatives of all nodes at a trajectory with these gaps (ndx x N), by dual numbers, column
/// by column (MovingNodes).
std::vector<NodeDerivatives> node_derivatives(const ShootingProblem& problem,
                                              const Trajectory& trajectory,
                                              const Eigen::MatrixXd& gap);

/// Those of one node.
NodeDerivatives derivatives_of_node(const ShootingProblem& problem, int node, MovingNodes& moving);

}  // namespace conddp
