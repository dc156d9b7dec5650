#pragma once

#include <vector>

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// Products with the Jacobians C of a problem's constraint rows, block by block of rows that depend
/// on the same columns. Pairs are left out.
class RowBlocks {
 public:
  explicit RowBlocks(const ShootingProblem& problem);

  /// Adds Cᵀ f to the gradients of the nodes; f has a number for each constraint row.
  void add_gradients(const Eigen::VectorXd& f, Linearization& to) const;
  /// Adds the lower triangle of Cᵀ diag(f) C to matrices, one for each node.
  void add_squares(const Eigen::VectorXd& f, const Linearization& linearization,
                   std::vector<Eigen::MatrixXd>& to);
  /// Computes C δz for a step of each node.
  void multiply(const Linearization& linearization, const std::vector<Eigen::VectorXd>& z,
                Eigen::VectorXd& out) const;

 private:
  struct Block {
    int node, row, rows;  ///< row: the first one among those of the problem
    int first;            ///< that row among those of the node
    const std::vector<int>* columns;
  };
  std::vector<Block> blocks_;
  Eigen::MatrixXd rows_;  ///< Cᵀ of a block
  Eigen::VectorXd column_, weights_;
};

}  // namespace conddp
