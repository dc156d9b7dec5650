#pragma once

#include <Eigen/Core>

#include "ocp/knot/knot_hessian.hpp"
#include "ocp/problem/problem.hpp"

namespace conddp {

/// H += Σ Cᵀ W C over a few rows C of a Jacobian at a time, with a symmetric W each: collected
/// first and added in one pass over H. Memory is sized at construction. C are derivatives of
/// constraint rows of the node, so that H stays within the pattern of the node's model.
class LowRankUpdate {
 public:
  /// For the Hessians of the problem's nodes and the constraint rows that they have.
  explicit LowRankUpdate(const ShootingProblem& problem);

  /// + weight · cᵀc.
  void add(const Eigen::Ref<const Eigen::RowVectorXd, 0, Eigen::InnerStride<>>& c, double weight) {
    rows_.col(count_).head(c.size()) = c;
    weighted_.col(count_++).head(c.size()) = weight * c;
  }
  /// + Cᵀ W C.
  void add(const Eigen::Ref<const Eigen::MatrixXd>& C, const Eigen::Ref<const Eigen::MatrixXd>& W);

  /// Whether nothing was added since the last apply().
  bool empty() const { return count_ == 0; }
  void apply(KnotHessian& hessian);

 private:
  Eigen::MatrixXd rows_, weighted_;  ///< Cᵀ and Cᵀ W, a column per row of C
  int count_ = 0;
};

}  // namespace conddp
