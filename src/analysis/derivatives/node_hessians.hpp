#pragma once

#include <vector>

#include <Eigen/Core>

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

}  // namespace conddp
