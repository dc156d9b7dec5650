#pragma once

#include <Eigen/Core>

#include "ocp/evaluation/linearization.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// H += Σ Cᵀ W C, where each C holds a few rows of a Jacobian and each W is symmetric. The terms
/// are collected and then added in one pass over H. Memory is sized at construction. The C are
/// derivatives of constraint rows of the node, so that H keeps the sparsity pattern of the node's
/// model.
class LowRankUpdate {
 public:
  /// Reserves memory for the Hessians and constraint rows of the problem's nodes.
  explicit LowRankUpdate(const ShootingProblem& problem);

  /// Adds weight · cᵀc.
  void add(const Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>>& c, double weight) {
    rows_.col(count_).head(c.size()) = c;
    weighted_.col(count_++).head(c.size()) = weight * c;
  }
  /// Adds Cᵀ W C.
  void add(const Eigen::Ref<const Eigen::MatrixXd>& C, const Eigen::Ref<const Eigen::MatrixXd>& W);

  /// True if nothing was added since the last apply().
  bool empty() const { return count_ == 0; }
  void apply(KnotHessian& hessian);

 private:
  Eigen::MatrixXd rows_, weighted_;  ///< Cᵀ and Cᵀ W, one column per row of C
  int count_ = 0;
};

}  // namespace conddp
