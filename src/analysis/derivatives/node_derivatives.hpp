#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A node and the direction of its motion in z = (δx, δu), nz numbers.
struct NodeMove {
  int node;
  const double* direction;
};

/// Destinations for the slopes of a node's values along a direction.
struct SlopePlaces {
  double* cost;
  double* constraint;  ///< one per constraint row of the node
  double* step;        ///< ndx, slope of f ⊕ (−gap) ⊖ x_{k+1}; null at the terminal node
};

/// Evaluates costs, constraints and dynamics at nodes of a trajectory in dual numbers, with a node
/// and a direction in each lane. No derivative formula of the solvers takes part.
class MovingNodes {
 public:
  /// `gap` (ndx x N) is that of the dynamics, which preserve it. All arguments must outlive this
  /// object.
  MovingNodes(const ShootingProblem& problem, const Trajectory& trajectory,
              const Eigen::MatrixXd& gap);
  ~MovingNodes();

  /// Evaluates at most kLaneWidth moves, all at nodes of one model.
  void evaluate(std::span<const NodeMove> moves);
  /// Writes the slopes of one move.
  void write(int move, const SlopePlaces& out) const;

 private:
  class Batch;

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const Eigen::MatrixXd& gap_;
  std::map<const KnotModel*, std::unique_ptr<Batch>> batches_;
  Batch* current_ = nullptr;
};

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
