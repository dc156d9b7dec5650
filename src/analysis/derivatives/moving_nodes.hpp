#pragma once

#include <map>
#include <memory>
#include <span>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// A node, and the direction in z = (δx, δu), nz numbers, along which it moves.
struct NodeMove {
  int node;
  const double* direction;
};

/// Where the slopes of a node's values along a direction go.
struct SlopePlaces {
  double* cost;
  double* constraint;  ///< one a constraint row of the node
  double* step;        ///< ndx, of f ⊕ (−gap) ⊖ x_{k+1}; null at the terminal node
};

/// Nodes of a trajectory in dual numbers through the evaluation of costs, constraints and dynamics,
/// a node and a direction in each lane. No formula of a derivative that solvers use has a part in
/// it.
class MovingNodes {
 public:
  /// `gap` (ndx x N) is that of the dynamics, which they keep. All three have to outlive this.
  MovingNodes(const ShootingProblem& problem, const Trajectory& trajectory,
              const Eigen::MatrixXd& gap);
  ~MovingNodes();

  /// At most kLaneWidth moves, of nodes of one model.
  void evaluate(std::span<const NodeMove> moves);
  /// The slopes of one of them.
  void write(int move, const SlopePlaces& out) const;

 private:
  class Batch;

  const ShootingProblem& problem_;
  const Trajectory& trajectory_;
  const Eigen::MatrixXd& gap_;
  std::map<const KnotModel*, std::unique_ptr<Batch>> batches_;
  Batch* current_ = nullptr;
};

}  // namespace conddp
