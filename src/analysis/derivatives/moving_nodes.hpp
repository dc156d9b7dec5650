#pragma once

#include <map>
#include <memory>
#include <span>

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

}  // namespace conddp
