#pragma once

#include <vector>

#include <Eigen/Core>

#include "analysis/derivatives/node_derivatives.hpp"
#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Hessians (nz x nz) of a model, node by node.
std::vector<Eigen::MatrixXd> hessians_of(const Linearization& model);

/// Gauss-Newton Hessians (nz x nz) of all nodes at a trajectory, without multiplier terms.
std::vector<Eigen::MatrixXd> gauss_newton_hessians(const ShootingProblem& problem,
                                                   const Trajectory& trajectory);

/// Exact Hessians of cost + λᵀf with these co-states (ndx x (N + 1)), plus the terms that an
/// augmentation adds to the cost.
std::vector<Eigen::MatrixXd> exact_hessians(const ShootingProblem& problem,
                                            const Trajectory& trajectory,
                                            const Eigen::MatrixXd& costates,
                                            const Augmentation* augmentation = nullptr);

/// Models of all nodes at a trajectory.
struct NodeModels {
  std::vector<NodeDerivatives> derivatives;
  std::vector<Eigen::MatrixXd> hessians;  ///< Gauss-Newton, nz x nz, without multiplier terms
  /// Number of nodes whose derivatives come from dual numbers.
  int by_dual_numbers = 0;
};

/// Models at a trajectory with these gaps (ndx x N). Derivatives equal those by dual numbers
/// (node_derivatives), to rounding. A node keeps its analytic derivatives if they agree with dual
/// numbers along two random directions, one of the state and one of the control. A wrong entry that
/// exceeds rounding spoils at least one of these products.
NodeModels node_models(const ShootingProblem& problem, const Trajectory& trajectory,
                       const Eigen::MatrixXd& gap);

/// The same from the analytic derivatives of all nodes, without multiplier terms.
NodeModels confirmed_models(const ShootingProblem& problem, const Trajectory& trajectory,
                            const Eigen::MatrixXd& gap, Linearization analytic);

}  // namespace conddp
